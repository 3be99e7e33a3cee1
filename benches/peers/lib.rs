//! Empty: the package consists of its bench.
