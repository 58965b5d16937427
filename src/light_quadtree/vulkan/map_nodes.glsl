// SPDX-License-Identifier: Apache-2.0
// The index of a node, as MapView::node.

uint node_of(GpuMapView view, uint level, uint x, uint y)
{
    return view.first + ((1u << (2 * level)) - 1) / 3 + (y << level) + x;
}

// The index of a level's first node among those of the levels from `start` on.
uint first_of_level(uint start, uint level)
{
    return ((1u << (2 * level)) - (1u << (2 * start))) / 3;
}
