//! `overfall surface`.
use crate::support::{assert_exit, folder_with_tiny, overfall, stderr};

#[cfg(not(feature = "surface"))]
#[test]
fn a_program_without_surfaces_says_how_to_get_them() {
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["surface", "out/tiny"]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("--features surface"),
        "{}",
        stderr(&output)
    );
}

#[cfg(feature = "surface")]
mod with_feature {
    use std::fs;

    use super::*;
    use crate::support::{names, stdout};

    fn run() -> tempfile::TempDir {
        let folder = folder_with_tiny();
        let run = [
            "run",
            "tiny.ron",
            "--quiet",
            "--duration",
            "0.01",
            "--no-pictures",
        ];
        assert_exit(&overfall(&folder, &run), 0);
        folder
    }

    /// The files are the same to the last byte for every number of threads, and nothing of an older call is left.
    #[test]
    fn surfaces_of_a_run_do_not_depend_on_threads() {
        let folder = run();
        let out = folder.path().join("out/tiny");
        let made = |threads: &str| {
            let options = [
                "surface",
                "out/tiny",
                "--format",
                "vtu,ply,obj",
                "--size",
                "160x90",
                "--threads",
                threads,
            ];
            let output = overfall(&folder, &options);
            assert_exit(&output, 0);
            assert!(
                stdout(&output).contains("5 surfaces"),
                "{}",
                stdout(&output)
            );
            let mut files = Vec::new();
            for part in ["surfaces", "surface_pictures"] {
                for name in names(&out.join(part)) {
                    files.push((fs::read(out.join(part).join(&name)).expect("a file"), name));
                }
            }
            files
        };
        let one = made("1");
        assert_eq!(one.len(), 4 * 5);
        assert!(made("3") == one);
        let series = fs::read_to_string(out.join("surface.pvd")).expect("a series");
        assert_eq!(series.matches("surfaces/frame_").count(), 5);
        // A picture without fluid is another picture.
        assert_ne!(one[15].0, one[19].0);
    }

    #[test]
    fn what_has_no_surface_is_refused() {
        let folder = run();
        for (options, status, said) in [
            (&["surface", "nowhere"][..], 2, "no run wrote this folder"),
            (
                &["surface", "out/tiny", "--cube-size", "99"],
                2,
                "at most 10 radii",
            ),
            (&["surface", "out/tiny", "--threshold", "1"], 2, "below 1"),
            (
                &["surface", "out/tiny", "--format", "stl"],
                2,
                "possible values",
            ),
        ] {
            let output = overfall(&folder, options);
            assert_exit(&output, status);
            assert!(stderr(&output).contains(said), "{}", stderr(&output));
        }
        let frame = folder.path().join("out/tiny/frames/frame_00002.vtu");
        let bytes = fs::read(&frame).expect("a frame");
        fs::write(&frame, &bytes[..bytes.len() / 2]).expect("cut short");
        let output = overfall(&folder, &["surface", "out/tiny", "--no-pictures"]);
        assert_exit(&output, 1);
        assert!(
            stderr(&output).contains("frame_00002.vtu"),
            "{}",
            stderr(&output)
        );
    }
}
