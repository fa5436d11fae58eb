// The groups of this benchmark. Each runs SFT and its references in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

/// Measures the time to make the payload with parts of a field from an encoded sample.
std::vector<Figure> gathering_parts(int rounds);
/// Measures loops over the points of a whole cloud and of a part, compared with loops that know the layout.
std::vector<Figure> reading_points(int rounds);
/// Measures loops over the pixels of an image and of a window in it, compared with loops that know the
/// layout.
std::vector<Figure> reading_cells(int rounds);
/// Measures the costs of a part of a cloud on the link between two hosts, in bytes and time.
std::vector<Figure> parts_between_hosts(std::uint64_t samples, int rounds);
/// Measures the costs of a part of a cloud on the link of a publisher to four hosts that request it.
std::vector<Figure> shared_part_of_hosts(std::uint64_t samples);
/// Measures the costs of conditions that do not hold: the publisher's time, and the wake-ups of a reader in
/// shared memory.
std::vector<Figure> closed_gates(int rounds, int samples);
/// Counts the bytes and samples of recorded messages that remain with parts and conditions, if the
/// recordings are on this machine.
std::vector<Figure> parts_of_recordings();
/// Measures the time from set_selection() to the first sample with the new window, between hosts.
std::vector<Figure> moved_windows(std::uint64_t moves, int rounds);

}  // namespace sft::bench
