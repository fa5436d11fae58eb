// The groups of this benchmark. Each runs SFT and its references in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

/// Measures the way from an encoded sample to the payload with parts of a field.
std::vector<Figure> gathering_parts(int rounds);
/// Measures loops over the points of a cloud, as a whole and as a part, against loops that know the layout.
std::vector<Figure> reading_points(int rounds);
/// Measures loops over the pixels of an image and of a window in it, against loops that know the layout.
std::vector<Figure> reading_cells(int rounds);
/// Measures what a part of a cloud costs on the link between two hosts, in bytes and time.
std::vector<Figure> parts_between_hosts(std::uint64_t samples, int rounds);
/// Measures what a part of a cloud costs on the link of a publisher with four hosts that ask for it.
std::vector<Figure> shared_part_of_hosts(std::uint64_t samples);
/// Measures what conditions that do not hold cost: the publisher time, and a reader in shared memory
/// wake-ups.
std::vector<Figure> closed_gates(int rounds, int samples);
/// Counts what parts and conditions leave of recorded messages, as far as the recordings are on this machine.
std::vector<Figure> parts_of_recordings();
/// Measures the time from set_selection() to the first sample with the new window, between hosts.
std::vector<Figure> moved_windows(std::uint64_t moves, int rounds);

}  // namespace sft::bench
