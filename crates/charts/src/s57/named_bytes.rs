//! Files as readers get them: the caller reads the folder or archive and gives each as a path with bytes.

/// A file by its path in the tree.
#[derive(Debug, Clone, Copy)]
pub struct NamedBytes<'a> {
    /// Path; `/` and `\` both separate.
    pub name: &'a str,
    /// Contents.
    pub bytes: &'a [u8],
}
