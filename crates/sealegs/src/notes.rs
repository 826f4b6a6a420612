//! Remarks on files for a reader: what is said of several runs is said once, with the range of its numbers.

/// Remarks as `FILE: text`, those of one text as one: of the files their number, of numbers that differ the least and the
/// greatest.
#[must_use]
pub fn together(notes: &[String]) -> Vec<String> {
    let mut groups: Vec<(Vec<Word>, Vec<&String>)> = Vec::new();
    for note in notes {
        let text = note.split_once(": ").map_or(note.as_str(), |(_, text)| text);
        let words: Vec<Word> = text.split(' ').map(Word::of).collect();
        let alike = |group: &&mut (Vec<Word>, Vec<&String>)| Word::are_alike(&group.0, &words);
        match groups.iter_mut().find(alike) {
            Some((known, of)) => {
                known.iter_mut().zip(&words).for_each(|(known, word)| known.widen(word));
                of.push(note);
            }
            None => groups.push((words, vec![note])),
        }
    }
    let said = |(words, of): (Vec<Word>, Vec<&String>)| match of[..] {
        [only] => only.clone(),
        _ => {
            let words: Vec<String> = words.into_iter().map(Word::said).collect();
            format!("{} runs: {}", of.len(), words.join(" "))
        }
    };
    groups.into_iter().map(said).collect()
}

/// A word of a remark.
enum Word {
    Text(String),
    /// The least and the greatest of a number, as they were written.
    Number((f64, String), (f64, String)),
}

impl Word {
    fn of(word: &str) -> Self {
        let written = || word.to_owned();
        let number = word.parse().ok().filter(|value: &f64| value.is_finite());
        number.map_or_else(|| Self::Text(written()), |v| Self::Number((v, written()), (v, written())))
    }

    /// Whether two texts differ in numbers only.
    fn are_alike(a: &[Self], b: &[Self]) -> bool {
        let alike = |(a, b): (&Self, &Self)| match (a, b) {
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Number(..), Self::Number(..)) => true,
            _ => false,
        };
        a.len() == b.len() && a.iter().zip(b).all(alike)
    }

    fn widen(&mut self, by: &Self) {
        if let (Self::Number(least, greatest), Self::Number(low, high)) = (self, by) {
            if low.0 < least.0 {
                *least = low.clone();
            }
            if high.0 > greatest.0 {
                *greatest = high.clone();
            }
        }
    }

    fn said(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Number((_, least), (_, greatest)) if least == greatest => least,
            Self::Number((_, least), (_, greatest)) => format!("{least} to {greatest}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::together;

    #[test]
    fn what_is_said_of_several_runs_is_said_once_with_the_range_of_its_numbers() {
        let notes = [
            "a.csv: steps of time vary by 0.162 ms about 5.303 ms; kept as they are",
            "a.csv: no channel is made of speed, temp; kept",
            "b.csv: steps of time vary by 0.932 ms about 3.510 ms; kept as they are",
            "b.csv: no channel is made of speed; kept",
            "c.csv: steps of time vary by 0.148 ms about 5.303 ms; kept as they are",
        ];
        assert_eq!(
            together(&notes.map(str::to_owned)),
            [
                "3 runs: steps of time vary by 0.148 to 0.932 ms about 3.510 to 5.303 ms; kept as they are",
                "a.csv: no channel is made of speed, temp; kept",
                "b.csv: no channel is made of speed; kept",
            ]
        );
    }

    #[test]
    fn remarks_of_one_text_on_one_file_stay_as_they_are() {
        let notes = ["all is well".to_owned()];
        assert_eq!(together(&notes), notes);
    }
}
