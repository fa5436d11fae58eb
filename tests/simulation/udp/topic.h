// The topic of the simulation: its type, its writer, and what its readers ask for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "core/control/control.h"
#include "core/seam/sample_buffer.h"
#include "tests/unit/udp/messages.h"

namespace sft::simulation {

using Cloud = sensor_msgs::msg::PointCloud2;

inline constexpr core::EndpointId writer_id = 0x7'0000'0001;
/// The writer is the low half of its ID on the wire.
inline constexpr auto writer_label = static_cast<std::uint32_t>(writer_id);
/// The writer hears answers at this port.
inline constexpr std::uint16_t writer_port = 7;

inline const TypeSupport& cloud_type() { return udp::test::type_support<Cloud>(); }

/// A cloud of a few rows with about so many bytes of data, whose bytes tell its number. There is room between
/// the channels and behind the rows.
Cloud make_cloud(std::size_t data_bytes, std::uint32_t number);

using Wish = std::size_t;  ///< an index of wishes()
/// The selections that readers ask for: first three masks, then channels and windows, and then some with
/// conditions on the number, some of these with windows. Behind the usual ones there are so many others with
/// conditions that a publisher does not keep all their gates.
const std::vector<Selection>& wishes();
inline constexpr Wish masks_end = 3, usual_wishes_end = 10;

/// The hash by which datagrams name the selection under which the sample came; 0: nobody asks for that.
std::uint64_t name_of_selection(const core::SampleBuffer& sample);
/// The bytes of the cloud under the selection that the sample names. REQUIRES: it names one.
std::vector<std::byte> body_under(const Cloud& cloud, const core::SampleBuffer& sample);

}  // namespace sft::simulation
