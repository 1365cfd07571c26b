//! "Did you mean": the accepted name that is nearest to one that is unknown.

/// The accepted name that a misspelled one may mean: at most a third of its letters are changed, left out, added or exchanged
/// with their neighbour.
pub fn nearest<'a>(said: &str, accepted: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let said = said.to_lowercase();
    let letters = said.chars().count();
    let most = (letters / 3).clamp(1, 3);
    let distance = |name: &str| match (name.to_lowercase(), letters) {
        (name, 0..3) if name.chars().count() != letters => usize::MAX,
        (name, _) => strsim::osa_distance(&said, &name),
    };
    accepted
        .into_iter()
        .map(|name| (distance(name), name))
        .filter(|(distance, _)| *distance <= most)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// A refusal of an unknown name, with the nearest accepted one behind it.
///
/// Refusals of names have two forms, ours, "`NAME` is unknown: accepted are A, B", and that of the file readers, "unknown
/// field `NAME`, expected one of `A`, `B`". Every other sentence is left as it is.
pub fn with_nearest(sentence: String) -> String {
    suggestion(&sentence).unwrap_or(sentence)
}

fn suggestion(sentence: &str) -> Option<String> {
    const READERS: [&str; 2] = ["unknown field `", "unknown variant `"];
    let (name, accepted) = if let Some(at) = READERS
        .iter()
        .find_map(|form| sentence.find(form).map(|at| at + form.len()))
    {
        (at, sentence.split_once(", expected ")?.1)
    } else {
        let end = sentence.find("` is unknown: accepted are ")?;
        let begin = sentence[..end].rfind('`')? + 1;
        (begin, sentence.split_once(": accepted are ")?.1)
    };
    let end = name + sentence[name..].find('`')?;
    let words = accepted
        .split([',', ' ', '`'])
        .filter(|word| !matches!(*word, "" | "one" | "of" | "or" | "and"));
    let near = nearest(&sentence[name..end], words)?;
    let (before, behind) = sentence.split_at(end + 1);
    Some(format!("{before} (`{near}`?){behind}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_fingers_is_recognised_and_another_word_is_not() {
        let verbs = ["run", "compare", "check", "sweep", "serve"];
        for (said, meant) in [
            ("rnu", Some("run")),
            ("comapre", Some("compare")),
            ("Check", Some("check")),
            ("sweeep", Some("sweep")),
            ("tcsh", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(nearest(said, verbs), meant, "{said}");
        }
    }

    #[test]
    fn a_refusal_names_what_may_have_been_meant() {
        for (sentence, with) in [
            (
                "t.toml: a.dealy_ms: unknown field `dealy_ms`, expected one of `kind`, `delay_ms`",
                "t.toml: a.dealy_ms: unknown field `dealy_ms` (`delay_ms`?), expected one of `kind`, `delay_ms`",
            ),
            (
                "unknown field `b`, expected `a` or `bb`",
                "unknown field `b` (`a`?), expected `a` or `bb`",
            ),
            (
                "the compensation `tangnet` is unknown: accepted are none, tangent, and FORCE+PREDICTOR",
                "the compensation `tangnet` (`tangent`?) is unknown: accepted are none, tangent, and FORCE+PREDICTOR",
            ),
        ] {
            assert_eq!(with_nearest(sentence.into()), with);
        }
        let other = "t.toml: mass_kg = -1 is refused: accepted are above 0";
        assert_eq!(with_nearest(other.into()), other);
    }
}
