// A small handwritten message type, {uint32 height, uint32 width, sequence<octet> data}, and functions for
// samples of this type.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/seam/transport.h"
#include "sft/detail/sample_format.h"
#include "sft/type_support.h"

namespace sft::test {

struct Frame {
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<std::uint8_t> data{};
};

}  // namespace sft::test

template <>
struct sft::detail::TypeTable<sft::test::Frame> {
  using T = sft::test::Frame;
  static constexpr std::array members{
      sft::detail::member<std::uint32_t>("height", sft::detail::Kind::uint32, offsetof(T, height)),
      sft::detail::member<std::uint32_t>("width", sft::detail::Kind::uint32, offsetof(T, width)),
      sft::detail::member<std::vector<std::uint8_t>>("data", sft::detail::Kind::uint8, offsetof(T, data))};
  static constexpr sft::StructType type{"sft::test::Frame", members};
};

namespace sft::test {

inline const TypeSupport& frame_type() {
  static const TypeSupport type(detail::TypeTable<Frame>::type);
  return type;
}

inline constexpr detail::SampleLayout frame_layout{3};
inline constexpr std::uint32_t data_offset = 12;  ///< offset of the data in the body

/// Returns the size in bytes of a sample with `data` bytes of data.
constexpr std::size_t frame_bytes(std::uint32_t data) { return frame_layout.bytes(data_offset + data); }

/// Writes the header, the index and the fixed fields. Leaves the data unchanged.
inline void write_frame(core::SampleBuffer& sample, core::EndpointId writer, std::uint64_t sequence,
                        std::uint32_t data) {
  detail::SampleHeader& header = sample.header();
  header.index_slots = 3;
  header.writer = writer;
  header.sequence = sequence;
  header.type_hash = frame_type().hash();
  header.body_offset = static_cast<std::uint32_t>(frame_layout.body_offset);
  header.body_bytes = data_offset + data;
  const std::uint32_t index[3] = {0, 4, 8};
  std::memcpy(sample.index(), index, sizeof index);
  const std::uint32_t fields[3] = {static_cast<std::uint32_t>(sequence), data, data};
  std::memcpy(sample.data + frame_layout.body_offset, fields, sizeof fields);
}

inline std::uint32_t field_of(const core::SampleBuffer& sample, std::size_t slot) {
  std::uint32_t value;
  std::memcpy(&value, sample.data + frame_layout.body_offset + sample.index()[slot], sizeof value);
  return value;
}

inline std::byte* data_of(const core::SampleBuffer& sample) {
  return sample.data + frame_layout.body_offset + data_offset;
}

}  // namespace sft::test
