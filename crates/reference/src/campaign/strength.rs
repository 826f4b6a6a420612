//! How strong an effect must be for the model without it to fail by a wanted amount.

/// Trials before giving up.
const TRIALS: usize = 14;

/// Greatest change of the strength from one trial to the next.
const STRIDE: f64 = 5.0;

/// Strengths beyond these are no effect any more, or the whole of the motion.
const RANGE: (f64, f64) = (1e-3, 300.0);

/// Searches a strength at which `error`, in noise units and about 1 for none, lies in a window; `None` where no
/// strength reaches it. What an effect leaves grows about in proportion to its strength, and adds to the noise in
/// squares.
///
/// # Errors
///
/// Whatever `error` returns.
pub fn reach<E>(window: (f64, f64), mut error: impl FnMut(f64) -> Result<f64, E>) -> Result<Option<f64>, E> {
    let excess = |e: f64| (e * e - 1.0).max(1e-3).sqrt();
    let wanted = excess((window.0 * window.1).sqrt());
    let (mut weak, mut strong): (Option<f64>, Option<f64>) = (None, None);
    let mut strength = 1.0;
    for _ in 0..TRIALS {
        let e = error(strength)?;
        if (window.0..=window.1).contains(&e) {
            return Ok(Some(strength));
        }
        if e < window.0 {
            weak = Some(weak.map_or(strength, |w| w.max(strength)));
        } else {
            strong = Some(strong.map_or(strength, |s| s.min(strength)));
        }
        let step = (wanted / excess(e)).clamp(1.0 / STRIDE, STRIDE);
        strength = match (weak, strong) {
            // Between the two where the proportion leads out of them.
            (Some(w), Some(s)) if w < s && !(w * 1.05..s / 1.05).contains(&(strength * step)) => {
                (w * s).sqrt()
            }
            _ => strength * step,
        };
        if !(RANGE.0..=RANGE.1).contains(&strength) {
            return Ok(None);
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_law_is_reached_and_an_invisible_one_given_up() {
        let law = |a: f64| -> Result<f64, ()> { Ok((1.0 + (0.02 * a.powf(1.5)).powi(2)).sqrt()) };
        let found = reach((1.3, 1.5), law).unwrap().unwrap();
        assert!((1.3..=1.5).contains(&law(found).unwrap()), "{found}");
        assert_eq!(reach((1.3, 1.5), |_| Ok::<f64, ()>(1.0)), Ok(None));
        // A threshold: nothing at all up to 7, then at once too much.
        let cliff = |a: f64| -> Result<f64, ()> { Ok(if a < 7.0 { 1.0 } else { 9.0 }) };
        assert_eq!(reach((1.3, 1.5), cliff), Ok(None));
        assert_eq!(reach((1.3, 1.5), |_| Err("no")), Err("no"));
    }
}
