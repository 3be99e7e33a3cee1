//! One bracket or two around the fields of a variant: `Dfsph()`, `Dfsph(())`, `Cfl(max: 1)`, `Cfl((max: 1))`.

use overfall::scene::Scene;

fn parse(rest: &str) -> Result<Scene, String> {
    let text = format!(
        "(name: \"b\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
{rest})"
    );
    Scene::parse(&text, "s.ron", &[]).map_err(|error| error.to_string())
}

#[test]
fn a_mistake_is_told_and_not_the_brackets_before_it() {
    for method in [
        "Dfsph(())",
        "Dfsph()",
        "Dfsph",
        "Pcisph((max_iterations: 9))",
    ] {
        for (slip, part) in [
            ("spacin: 1", "unknown field `spacin`"),
            ("time_step: Fixd(0.01)", "did you mean `Fixed`?"),
            ("duration: 1s", "did you mean `1`?"),
            ("gravity: 3", "a vector of three numbers"),
        ] {
            let error = parse(&format!("pressure: {method},\n{slip}")).expect_err(slip);
            assert!(
                error.contains(part) && error.contains("s.ron:3:"),
                "{method}: {error}"
            );
        }
    }
}

/// Empty brackets are the same in both spellings, so they go with either.
#[test]
fn empty_brackets_in_brackets_go_with_either_spelling() {
    for step in [
        "Cfl(max: 0.01)",
        "Cfl((max: 0.01))",
        "Cfl()",
        "Cfl(())",
        "Cfl",
    ] {
        for method in ["Dfsph(())", "Dfsph()", "Dfsph"] {
            let rest = format!("pressure: {method}, time_step: {step}");
            parse(&rest).unwrap_or_else(|error| panic!("{rest}: {error}"));
        }
    }
}
