//! The bytes of an accessor.

use gltf::Accessor;

/// The bytes of each item of an accessor, whose every number is checked against the buffer.
pub(crate) fn items<'a>(
    accessor: &Accessor,
    buffers: &'a [Vec<u8>],
) -> Result<Vec<&'a [u8]>, String> {
    let outside =
        || format!("refers to accessor {}, which reaches beyond its buffer", accessor.index());
    let view = accessor
        .view()
        .filter(|_| accessor.sparse().is_none())
        .ok_or_else(|| format!("refers to accessor {}, which is sparse", accessor.index()))?;
    let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
    let bytes = buffers[view.buffer().index()].get(view.offset()..end).ok_or_else(outside)?;
    let stride = view.stride().unwrap_or(accessor.size()).max(accessor.size());
    let mut items = Vec::new();
    let mut start = accessor.offset();
    for _ in 0..accessor.count() {
        let item = start
            .checked_add(accessor.size())
            .and_then(|end| bytes.get(start..end))
            .ok_or_else(outside)?;
        items.push(item);
        start = start.saturating_add(stride);
    }
    Ok(items)
}
