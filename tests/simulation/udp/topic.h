// The topic of the simulation: its type, its writer, and the masks under which its readers ask for samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/control/control.h"
#include "tests/unit/udp/messages.h"

namespace sft::simulation {

using udp::test::Image;

inline constexpr core::EndpointId writer_id = 0x7'0000'0001;
/// The writer is the low half of its ID on the wire.
inline constexpr auto writer_label = static_cast<std::uint32_t>(writer_id);
/// The writer hears answers at this port.
inline constexpr std::uint16_t writer_port = 7;

using Mask = std::size_t;  ///< an index of masks()
const std::vector<FieldMask>& masks();

inline const TypeSupport& image_type() { return udp::test::type_support<Image>(); }

}  // namespace sft::simulation
