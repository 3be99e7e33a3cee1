//! Frame files can be read back, and a damaged file gives an error, never a panic.

use std::fs;
use std::path::Path;

use glam::Vec3;
use overfall::output::{FIELDS, Frame, OutputError, Series};
use overfall::scene::FrameFormat;

const FORMATS: [FrameFormat; 2] = [FrameFormat::Vtu, FrameFormat::Ply];

fn some_frame(rows: u32) -> Frame {
    let of = |row: u32| row as f32 * 0.1;
    Frame {
        step: 42,
        time: 0.1 + 0.2,
        ids: (0..rows).rev().collect(),
        positions: (0..rows).map(|i| Vec3::new(of(i), 1.5, -of(i))).collect(),
        velocities: (0..rows).map(|i| Vec3::new(-of(i), 1e-30, 2.0)).collect(),
        densities: (0..rows).map(|i| 1000.0 + of(i)).collect(),
        pressures: (0..rows).map(|i| 1e5 * of(i)).collect(),
    }
}

#[test]
fn frames_are_read_back_bit_for_bit() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    for format in FORMATS {
        for rows in [0, 1, 1000] {
            let frame = some_frame(rows);
            let path = folder.path().join(format!("a.{}", format.extension()));
            frame.write(&path, format)?;
            assert_eq!(Frame::read(&path)?, frame);
        }
    }
    Ok(())
}

/// Earlier versions wrote raw data after the head.
#[test]
fn frames_with_raw_data_are_read() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let frame = some_frame(3);
    let fields: [(&str, &str, u8, Vec<u8>); 5] = [
        ("position", "Float32", 3, vectors(&frame.positions)),
        ("velocity", "Float32", 3, vectors(&frame.velocities)),
        ("density", "Float32", 1, scalars(&frame.densities)),
        ("pressure", "Float32", 1, scalars(&frame.pressures)),
        (
            "id",
            "UInt32",
            1,
            frame.ids.iter().flat_map(|id| id.to_le_bytes()).collect(),
        ),
    ];
    let (mut head, mut data) = (String::new(), Vec::new());
    for (name, kind, components, bytes) in fields {
        let offset = data.len();
        head += &format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"appended\" offset=\"{offset}\"/>\n"
        );
        data.extend((bytes.len() as u64).to_le_bytes());
        data.extend(bytes);
    }
    let head = format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <DataArray Name=\"TimeValue\" format=\"ascii\">{}</DataArray>\n\
         <DataArray Name=\"step\" format=\"ascii\">{}</DataArray>\n\
         <Piece NumberOfPoints=\"3\">\n{head}<AppendedData encoding=\"raw\">\n_",
        frame.time, frame.step
    );
    let path = folder.path().join("a.vtu");
    let file = [head.as_bytes(), &data, b"\n</AppendedData>\n</VTKFile>\n"];
    fs::write(&path, file.concat()).unwrap();
    assert_eq!(Frame::read(&path)?, frame);
    Ok(())
}

fn scalars(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

fn vectors(values: &[Vec3]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| scalars(&value.to_array()))
        .collect()
}

#[test]
fn values_that_are_not_numbers_survive() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let mut frame = some_frame(2);
    frame.pressures = vec![f32::INFINITY, f32::NAN];
    for format in FORMATS {
        let path = folder.path().join(format!("a.{}", format.extension()));
        frame.write(&path, format)?;
        let back = Frame::read(&path)?;
        assert!(back.pressures[0].is_infinite() && back.pressures[1].is_nan());
    }
    Ok(())
}

#[test]
fn a_truncated_frame_is_an_error_wherever_it_ends() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    for format in FORMATS {
        let path = folder.path().join(format!("a.{}", format.extension()));
        some_frame(7).write(&path, format)?;
        let whole = fs::read(&path).unwrap();
        // Every position near the end, every seventh elsewhere: writing thousands of files takes long.
        let late = whole.len() - 60;
        for length in (0..late).step_by(7).chain(late..whole.len()) {
            fs::write(&path, &whole[..length]).unwrap();
            let error = Frame::read(&path).expect_err("a part of a file is no frame");
            assert!(matches!(error, OutputError::Malformed { .. }), "{error}");
        }
    }
    Ok(())
}

#[test]
fn a_frame_with_a_damaged_header_never_panics() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    for format in FORMATS {
        let path = folder.path().join(format!("a.{}", format.extension()));
        some_frame(3).write(&path, format)?;
        let whole = fs::read(&path).unwrap();
        // Larger numbers, other letters, broken tags: whatever a byte becomes, the result is a frame or an error.
        let bytes = [b'9', b'"', b'<', 0xff, b' '];
        for at in (0..whole.len()).step_by(3) {
            let mut damaged = whole.clone();
            damaged[at] = bytes[at % bytes.len()];
            fs::write(&path, &damaged).unwrap();
            let _ = Frame::read(&path);
        }
        let huge = String::from_utf8_lossy(&whole)
            .replace(
                "NumberOfPoints=\"3\"",
                "NumberOfPoints=\"18446744073709551615\"",
            )
            .replace("vertex 3\n", "vertex 18446744073709551615\n");
        fs::write(&path, huge).unwrap();
        assert!(Frame::read(&path).is_err());
    }
    Ok(())
}

#[test]
fn columns_of_different_lengths_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut frame = some_frame(3);
    frame.densities.pop();
    let path = folder.path().join("a.vtu");
    let error = frame.write_vtu(&path).expect_err("a column is short");
    assert!(matches!(
        error,
        OutputError::UnequalColumns {
            field: "density",
            found: 2,
            expected: 3
        }
    ));
    assert!(!path.exists());
}

#[test]
fn an_unknown_ending_and_a_missing_file_are_errors() {
    let read = |name: &str| Frame::read(Path::new(name)).expect_err("nothing to read");
    assert!(matches!(read("a.obj"), OutputError::UnknownFormat { .. }));
    assert!(matches!(read("absent/a.vtu"), OutputError::Io { .. }));
}

#[test]
fn writing_leaves_no_temporary_file() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let frame = some_frame(3);
    frame.write_vtu(&folder.path().join("a.vtu"))?;
    assert!(
        frame
            .write_vtu(&folder.path().join("absent/a.vtu"))
            .is_err()
    );
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names, ["a.vtu"]);
    Ok(())
}

#[test]
fn a_series_is_valid_after_every_frame_and_drops_what_is_drawn_again() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.pvd");
    let mut series = Series::new(&path);
    for (time, file) in [(0.0, "a.vtu"), (0.04, "b & \"c\".vtu"), (0.08, "d.vtu")] {
        series.push(time, file)?;
        assert_eq!(Series::read(&path)?, series);
    }
    let mut resumed = Series::read(&path)?;
    resumed.push(0.05, "e.vtu")?;
    let files: Vec<_> = resumed.entries().iter().map(|e| e.file.as_str()).collect();
    assert_eq!(files, ["a.vtu", "b & \"c\".vtu", "e.vtu"]);
    Ok(())
}

#[test]
fn a_truncated_series_is_an_error() -> Result<(), OutputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.pvd");
    Series::new(&path).push(0.5, "a.vtu")?;
    let whole = fs::read(&path).unwrap();
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(
            Series::read(&path).is_err(),
            "{length} of {} bytes",
            whole.len()
        );
    }
    Ok(())
}

#[test]
fn every_field_has_a_unit_and_a_sentence() {
    for field in &FIELDS {
        assert!(!field.unit.is_empty() && field.sentence.len() > 10);
        assert!(matches!(field.components(), 1 | 3));
    }
}
