// The topic of the simulation: its type, its writer, and the wishes of its readers.
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
/// Datagrams name the writer by the low half of its id.
inline constexpr auto writer_label = static_cast<std::uint32_t>(writer_id);
/// The port at which the writer receives answers.
inline constexpr std::uint16_t writer_port = 7;

inline const TypeSupport& cloud_type() { return udp::test::type_support<Cloud>(); }

/// Returns a cloud of a few rows with about `data_bytes` bytes of data, which depend on `number`. There are
/// gaps between the channels, and padding behind the rows.
Cloud make_cloud(std::size_t data_bytes, std::uint32_t number);

using Wish = std::size_t;  ///< an index of wishes()
/// Returns the selections that readers request. The usual ones come first: three masks, then channels and
/// windows, then conditions on the number, partly with windows. The rest are many selections with conditions,
/// more than the gates that a publisher keeps.
const std::vector<Selection>& wishes();
inline constexpr Wish masks_end = 3, usual_wishes_end = 10;

/// Returns the hash of the sample's selection in datagrams, or 0 if no reader requests that selection.
std::uint64_t name_of_selection(const core::SampleBuffer& sample);
/// Returns the bytes of the cloud under the selection that the sample names. REQUIRES: the sample names a
/// wish.
std::vector<std::byte> body_under(const Cloud& cloud, const core::SampleBuffer& sample);

}  // namespace sft::simulation
