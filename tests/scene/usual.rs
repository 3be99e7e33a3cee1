//! Values that refusals call usual: they are those of a scene that writes none, and they are accepted.

use overfall::scene::Scene;

/// A scene with one more field.
fn scene(more: &str) -> Result<Scene, String> {
    let text = format!(
        "(name: \"u\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
        boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))], {more})"
    );
    Scene::parse(&text, "u.ron", &[]).map_err(|error| error.to_string())
}

/// The number that a refusal calls usual.
fn usual(said: &str) -> &str {
    let before = said.split(" is usual").next().unwrap_or_default();
    before.rsplit([' ', '(']).next().unwrap_or_default()
}

#[test]
fn what_is_called_usual_is_the_default_and_accepted() {
    let mut fields = vec![
        ("support: {}".to_owned(), "9"),
        ("neighbours: Verlet(skin: {})".to_owned(), "2"),
        ("time_step: Cfl(factor: {})".to_owned(), "7"),
        (
            "boundary_handling: DirectForcing(rest_distance: {})".to_owned(),
            "9",
        ),
        (
            "output: (camera: (position: (1, 1, 1), target: (0, 0, 0), field_of_view: {}))"
                .to_owned(),
            "200",
        ),
    ];
    for method in ["Pcisph", "Iisph", "Dfsph"] {
        for (parameter, wrong) in [
            ("recovery", "1.5"),
            ("stabilisation", "9"),
            ("relaxation", "3"),
        ] {
            if (method, parameter) != ("Pcisph", "relaxation") {
                fields.push((format!("pressure: {method}({parameter}: {{}})"), wrong));
            }
        }
    }
    for (field, wrong) in fields {
        let said = scene(&field.replace("{}", wrong)).expect_err(&field);
        let usual = usual(&said);
        assert!(usual.parse::<f32>().is_ok(), "{field}: {said}");
        let written = scene(&field.replace("{}", usual)).unwrap_or_else(|error| panic!("{error}"));
        // Without the parameter: the brackets around it stay.
        let (before, _) = field.rsplit_once([' ', '(']).expect("a value");
        let name = before.rsplit([' ', '(']).next().unwrap_or_default();
        let empty = field.replace(&format!("{name} {{}}"), "");
        let left_out =
            scene(empty.trim_end_matches(", ")).unwrap_or_else(|error| panic!("{empty}: {error}"));
        // A written support selects another kernel.
        if name != "support:" {
            assert_eq!(written, left_out, "{field}: {usual}");
        }
    }
}
