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
/// Measures the costs of a part of a cloud on the link between two hosts, in bytes and time.
std::vector<Figure> parts_between_hosts(std::uint64_t samples, int rounds);
/// Measures the costs of points of a recorded cloud for three readers on another host, and for one of them,
/// in three ways: by selections, by a separate topic for each reader, and by compression of the whole
/// cloud. Returns nothing if there is no recording.
std::vector<Figure> beside_narrow_topics_and_compression(std::uint64_t clouds, int rounds);
/// Measures the time that a publisher needs to evaluate conditions that do not hold.
std::vector<Figure> closed_gates(int rounds);
/// Measures the time from set_selection() to the first sample with the new window, between hosts.
std::vector<Figure> moved_windows(std::uint64_t moves, int rounds);

}  // namespace sft::bench
