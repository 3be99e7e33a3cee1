//! Particles from a file: PLY, VTU or CSV, by the ending of its name.

mod csv;
mod particles;
#[cfg(feature = "ply")]
mod ply;
mod vtu;

use std::path::Path;

use glam::DVec3;

pub(crate) use particles::Particles;

impl Particles {
    /// Reads a file. The message names it, what is wrong, where, and the remedy.
    pub(crate) fn load(file: &Path) -> Result<Self, String> {
        let refuse = |message: String| format!("the particles {}: {message}", file.display());
        let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
        let read = match extension.to_str() {
            #[cfg(feature = "ply")]
            Some("ply") => ply::read,
            #[cfg(not(feature = "ply"))]
            Some("ply") => {
                let message = "this program was built without the feature `ply`; build it with that, or write VTU";
                return Err(refuse(message.to_owned()));
            }
            Some("vtu") => vtu::read,
            Some("csv") => return csv::read(file).and_then(|found| found.proper(&refuse)),
            _ => {
                return Err(refuse(
                    "its name ends neither in .ply nor in .vtu or .csv, the formats that can be read".to_owned(),
                ));
            }
        };
        let bytes = crate::input::read_bytes(file);
        let bytes = bytes.map_err(|error| refuse(format!("the file cannot be read: {error}")))?;
        read(&bytes).map_err(&refuse)?.proper(&refuse)
    }

    fn proper(self, refuse: &dyn Fn(String) -> String) -> Result<Self, String> {
        if self.positions.is_empty() {
            return Err(refuse("it has no particle; leave the body out".to_owned()));
        }
        let numbers = |values: &[DVec3]| values.iter().position(|value| !value.is_finite());
        let named = [
            ("position", numbers(&self.positions)),
            ("velocity", self.velocities.as_deref().and_then(numbers)),
        ];
        for (what, place) in named {
            if let Some(place) = place {
                return Err(refuse(format!(
                    "the {what} of particle {place} (the first is 0) is not finite; it must be numbers"
                )));
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(name: &str, content: &[u8]) -> Result<Particles, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join(name);
        std::fs::write(&file, content).expect("a file");
        Particles::load(&file)
    }

    fn two() -> Particles {
        Particles {
            positions: vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(-0.5, 0.25, 4.0)],
            velocities: Some(vec![DVec3::new(0.5, 0.0, -1.0), DVec3::ZERO]),
        }
    }

    const PLY_HEAD: &str = "comment a\nelement vertex 2\nproperty float x\nproperty double y\nproperty float z\n\
                            property uchar red\nproperty float vx\nproperty float vy\nproperty float vz\n\
                            element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn binary(big: bool) -> Vec<u8> {
        let kind = if big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{kind}_endian 1.0\n{PLY_HEAD}").into_bytes();
        let two = two();
        for (x, v) in two.positions.iter().zip(two.velocities.iter().flatten()) {
            let mut put = |little: &[u8]| {
                let mut value = little.to_vec();
                if big {
                    value.reverse();
                }
                bytes.extend(value);
            };
            put(&(x.x as f32).to_le_bytes());
            put(&x.y.to_le_bytes());
            put(&(x.z as f32).to_le_bytes());
            put(&[9]);
            for part in v.to_array() {
                put(&(part as f32).to_le_bytes());
            }
        }
        bytes.push(0);
        bytes
    }

    /// One set of particles in every format, with and without velocities.
    #[test]
    fn all_formats_hold_the_same_particles() {
        let ascii =
            format!("ply\nformat ascii 1.0\n{PLY_HEAD}1 2 3 9 0.5 0 -1\n-0.5 0.25 4 9 0 0 0\n0\n");
        let vtu = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
                   byte_order=\"LittleEndian\" header_type=\"UInt64\"><UnstructuredGrid>\
                   <Piece NumberOfPoints=\"2\" NumberOfCells=\"0\">\n<PointData><DataArray type=\"Float32\" \
                   Name=\"velocity\" NumberOfComponents=\"3\" format=\"ascii\">0.5 0 -1 0 0 0</DataArray></PointData>\
                   <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">1 2 3\n-0.5 0.25 4\
                   </DataArray></Points></Piece></UnstructuredGrid></VTKFile>";
        for (name, content) in [
            ("p.ply", ascii.as_bytes()),
            ("p.PLY", &binary(false)),
            ("p.ply", &binary(true)),
            ("p.vtu", vtu.as_bytes()),
            (
                "p.csv",
                b"x,y,z,vx,vy,vz\n1,2,3,0.5,0,-1\n-0.5,0.25,4,0,0,0\n",
            ),
        ] {
            assert_eq!(load(name, content).as_ref(), Ok(&two()), "{name}");
        }
        let still = Particles {
            velocities: None,
            ..two()
        };
        let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                   end_header\n1 2 3\n-0.5 0.25 4\n";
        assert_eq!(load("p.ply", ply.as_bytes()), Ok(still.clone()));
        assert_eq!(load("p.csv", b"x,y,z\n1,2,3\n-0.5,0.25,4\n"), Ok(still));
        let flat = load("p.csv", b"x,y\n1,2\n").expect("in the plane");
        assert_eq!(flat.positions, [DVec3::new(1.0, 2.0, 0.0)]);
    }

    #[test]
    fn what_is_no_set_of_particles_is_refused_with_its_place() {
        let ply = |head: &str, rest: &str| {
            format!("ply\nformat ascii 1.0\n{head}end_header\n{rest}").into_bytes()
        };
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let mut cut = binary(false);
        cut.truncate(cut.len() - 20);
        for (name, content, expected) in [
            ("p.xyz", b"1 2 3".to_vec(), "neither in .ply nor in .vtu or .csv"),
            ("p.ply", b"solid\n".to_vec(), "line 1"),
            ("p.ply", ply(&format!("element point 1\n{xyz}"), "1 2 3\n"), "no element `vertex`"),
            ("p.ply", ply("element vertex 1\nproperty float x\n", "1\n"), "no property `y`"),
            ("p.ply", ply(&format!("element vertex 2\n{xyz}"), "1 2 3\n1 b 3\n"), "line 9"),
            ("p.ply", ply(&format!("element vertex 1\n{xyz}"), "1 nan 3\n"), "line 8"),
            ("p.ply", ply(&format!("element vertex 0\n{xyz}"), ""), "no particle"),
            (
                "p.ply",
                ply(&format!("element vertex 900000000\n{xyz}"), "1 2 3\n"),
                "at most 200 million",
            ),
            (
                "p.ply",
                ply(&format!("element vertex 90000\n{xyz}"), "1 2 3\n"),
                "is too short",
            ),
            ("p.ply", cut, "end of"),
            ("p.csv", b"x,y,speed\n1,2,3\n".to_vec(), "unknown column `speed`"),
            ("p.csv", b"x,y,z\n1,2,a\n".to_vec(), "p.csv:2"),
            ("p.vtu", b"<VTKFile>".to_vec(), "NumberOfPoints"),
            (
                "p.vtu",
                b"<VTKFile><Piece NumberOfPoints=\"1\"><Points><DataArray type=\"Float32\" \
                  NumberOfComponents=\"3\" format=\"ascii\">1 nan 3</DataArray></Points></VTKFile>"
                    .to_vec(),
                "position of particle 0",
            ),
            (
                "p.vtu",
                b"<VTKFile byte_order=\"BigEndian\"><Piece NumberOfPoints=\"1\"><Points><DataArray \
                  type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">1 2</DataArray></Points></VTKFile>"
                    .to_vec(),
                "2 numbers",
            ),
            (
                "p.vtu",
                b"<VTKFile><Piece NumberOfPoints=\"1\"><Points><DataArray type=\"Float32\" \
                  NumberOfComponents=\"3\" format=\"binary\">AAAA</DataArray></Points></VTKFile>"
                    .to_vec(),
                "ends within its points",
            ),
        ] {
            let error = load(name, &content).expect_err(expected);
            assert!(error.contains(expected) && error.contains("p."), "{error}");
        }
    }
}
