// The topic of the simulation: its type, its writer, and what its readers ask for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/control/control.h"
#include "core/seam/sample_buffer.h"
#include "tests/unit/udp/messages.h"

namespace sft::simulation {

using udp::test::Image;

inline constexpr core::EndpointId writer_id = 0x7'0000'0001;
/// The writer is the low half of its ID on the wire.
inline constexpr auto writer_label = static_cast<std::uint32_t>(writer_id);
/// The writer hears answers at this port.
inline constexpr std::uint16_t writer_port = 7;

inline const TypeSupport& image_type() { return udp::test::type_support<Image>(); }

using Wish = std::size_t;  ///< an index of wishes()
/// The selections that readers ask for: first three masks, then windows, and then some with conditions on the
/// height, some of these with windows.
const std::vector<Selection>& wishes();
inline constexpr Wish masks_end = 3;

/// The hash by which datagrams name the selection under which the sample came; 0: nobody asks for that.
std::uint64_t name_of_selection(const core::SampleBuffer& sample);
/// The bytes of the image under the selection that the sample names. REQUIRES: it names one.
std::vector<std::byte> body_under(const Image& image, const core::SampleBuffer& sample);

}  // namespace sft::simulation
