//! What a model that wraps another one passes on to it.

/// The methods of [`Model`](crate::Model) that a model around another one passes on unchanged. To be used inside its
/// `impl Model`: it has the other one in its field `inner`, and its method `around(&self, Box<dyn Model>) -> Box<dyn Model>`
/// makes the same around another one. Written once, as a copy that a wrapper forgets to pass on is silently none.
#[macro_export]
macro_rules! passes_on_to_inner {
    () => {
        fn inputs(&self) -> &[&'static str] {
            self.inner.inputs()
        }

        fn predicts(&self, channel: &str) -> bool {
            self.inner.predicts(channel)
        }

        fn included(&self) -> Vec<String> {
            self.inner.included()
        }

        fn effects(&self, seen: &$crate::Excitation) -> Vec<$crate::EffectCard> {
            self.inner.effects(seen)
        }

        fn with_effect(
            &self,
            id: &str,
            seen: &$crate::Excitation,
        ) -> std::result::Result<Box<dyn $crate::Model>, $crate::ModelError> {
            self.inner.with_effect(id, seen).map(|model| self.around(model))
        }

        fn rotary_places(&self) -> Vec<String> {
            self.inner.rotary_places()
        }

        fn experiments(&self) -> Vec<$crate::Record> {
            self.inner.experiments()
        }

        fn is_dear(&self) -> bool {
            self.inner.is_dear()
        }

        fn coarser(&self, steps_per_sample: f64) -> Box<dyn $crate::Model> {
            self.around(self.inner.coarser(steps_per_sample))
        }

        fn finer(&self) -> Option<Box<dyn $crate::Model>> {
            self.inner.finer().map(|model| self.around(model))
        }

        fn observing(&self, records: &[&$crate::Record]) -> Option<Box<dyn $crate::Model>> {
            self.inner.observing(records).map(|model| self.around(model))
        }

        fn forgetting(&self, records: &[&$crate::Record], memory_s: f64) -> Option<Box<dyn $crate::Model>> {
            self.inner.forgetting(records, memory_s).map(|model| self.around(model))
        }

        fn knowing(&self, law: &$crate::Law) -> Option<Box<dyn $crate::Model>> {
            self.inner.knowing(law).map(|model| self.around(model))
        }

        fn clone_box(&self) -> Box<dyn $crate::Model> {
            self.around(self.inner.clone_box())
        }
    };
}
