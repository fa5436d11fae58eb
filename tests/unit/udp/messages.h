// Message types for the tests of the UDP transport, and functions that encode samples of these types like a
// publisher.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "sft/detail/encode.h"
#include "sft/type_support.h"

namespace sft::udp::test {

struct Stamp {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};

struct Image {
  Stamp stamp;
  std::string name;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<std::uint8_t> data;
};

struct Ten {
  std::array<std::uint32_t, 3> a{};
  std::uint8_t b = 0, c = 0, d = 0, e = 0, f = 0, g = 0, h = 0, i = 0;
  double j = 0;
};

struct Wide {  ///< a struct of 70 leaves
  Ten first, second, third, fourth, fifth, sixth, seventh;
};

}  // namespace sft::udp::test

template <>
struct sft::detail::TypeTable<sft::udp::test::Stamp> {
  using T = sft::udp::test::Stamp;
  static constexpr std::array members{
      member<std::int32_t>("sec", detail::Kind::int32, offsetof(T, sec)),
      member<std::uint32_t>("nanosec", detail::Kind::uint32, offsetof(T, nanosec))};
  static constexpr StructType type{"test::Stamp", members};
};

template <>
struct sft::detail::TypeTable<sft::udp::test::Image> {
  using T = sft::udp::test::Image;
  static constexpr std::array members{
      member<sft::udp::test::Stamp>("stamp", detail::Kind::structure, offsetof(T, stamp)),
      member<std::string>("name", detail::Kind::string, offsetof(T, name)),
      member<std::uint32_t>("height", detail::Kind::uint32, offsetof(T, height)),
      member<std::uint32_t>("width", detail::Kind::uint32, offsetof(T, width)),
      member<std::vector<std::uint8_t>>("data", detail::Kind::uint8, offsetof(T, data))};
  static constexpr StructType type{"test::Image", members};
};

template <>
struct sft::detail::TypeTable<sft::udp::test::Ten> {
  using T = sft::udp::test::Ten;
  static constexpr std::array members{
      member<std::array<std::uint32_t, 3>>("a", detail::Kind::uint32, offsetof(T, a)),
      member<std::uint8_t>("b", detail::Kind::uint8, offsetof(T, b)),
      member<std::uint8_t>("c", detail::Kind::uint8, offsetof(T, c)),
      member<std::uint8_t>("d", detail::Kind::uint8, offsetof(T, d)),
      member<std::uint8_t>("e", detail::Kind::uint8, offsetof(T, e)),
      member<std::uint8_t>("f", detail::Kind::uint8, offsetof(T, f)),
      member<std::uint8_t>("g", detail::Kind::uint8, offsetof(T, g)),
      member<std::uint8_t>("h", detail::Kind::uint8, offsetof(T, h)),
      member<std::uint8_t>("i", detail::Kind::uint8, offsetof(T, i)),
      member<double>("j", detail::Kind::float64, offsetof(T, j))};
  static constexpr StructType type{"test::Ten", members};
};

template <>
struct sft::detail::TypeTable<sft::udp::test::Wide> {
  using T = sft::udp::test::Wide;
  using Ten = sft::udp::test::Ten;
  static constexpr std::array members{member<Ten>("first", detail::Kind::structure, offsetof(T, first)),
                                      member<Ten>("second", detail::Kind::structure, offsetof(T, second)),
                                      member<Ten>("third", detail::Kind::structure, offsetof(T, third)),
                                      member<Ten>("fourth", detail::Kind::structure, offsetof(T, fourth)),
                                      member<Ten>("fifth", detail::Kind::structure, offsetof(T, fifth)),
                                      member<Ten>("sixth", detail::Kind::structure, offsetof(T, sixth)),
                                      member<Ten>("seventh", detail::Kind::structure, offsetof(T, seventh))};
  static constexpr StructType type{"test::Wide", members};
};

namespace sft::udp::test {

template <class T>
const TypeSupport& type_support() {
  static const TypeSupport type(detail::TypeTable<T>::type);
  return type;
}

/// Returns the mask of the fields of T that the text names, such as "stamp, data"; "*" names all fields.
template <class T>
FieldMask fields(std::string_view text) {
  return type_support<T>().closed(type_support<T>().parse_mask(text).value());
}

/// Returns the selection that a subscriber requests by this text, such as "stamp, data[::2]".
template <class T>
Selection selection_of(std::string_view text) {
  return type_support<T>().closed(type_support<T>().parse_selection(text).value());
}

template <class T>
std::vector<std::byte> encoded_body(const T& value, const FieldMask& mask) {
  const TypeSupport& type = type_support<T>();
  std::vector<std::byte> body(detail::encoded_size(type.type(), &value, mask).bytes);
  std::vector<std::uint32_t> index(type.index_slots());
  detail::encode(type.type(), &value, mask, body, index);
  return body;
}

/// Returns the size of a buffer for a sample of `value`.
template <class T>
std::size_t sample_bytes(const T& value, const FieldMask& mask) {
  const TypeSupport& type = type_support<T>();
  return detail::SampleLayout(type.index_slots())
      .bytes(detail::encoded_size(type.type(), &value, mask).bytes);
}

template <class T>
void fill(core::SampleBuffer& buffer, const T& value, const FieldMask& mask, std::uint64_t writer,
          std::uint64_t sequence, detail::PostponedCopies* postponed = nullptr) {
  const TypeSupport& type = type_support<T>();
  const detail::SampleLayout layout(type.index_slots());
  const std::uint32_t bytes = detail::encoded_size(type.type(), &value, mask).bytes;
  detail::SampleHeader& header = buffer.header();
  header.index_slots = static_cast<std::uint16_t>(type.index_slots());
  header.writer = writer;
  header.sequence = sequence;
  header.source_stamp_ns = static_cast<std::int64_t>(1000 + sequence);
  header.type_hash = type.hash();
  header.body_offset = static_cast<std::uint32_t>(layout.body_offset);
  header.body_bytes = bytes;
  buffer.trust_header();
  buffer.mask = mask;
  detail::encode(type.type(), &value, mask, {buffer.data + layout.body_offset, bytes},
                 {buffer.index(), type.index_slots()}, {}, postponed);
}

/// Returns true if the bytes are equal. Uses memcmp, which is fast even in builds without optimisation.
inline bool same_bytes(std::span<const std::byte> a, std::span<const std::byte> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
}

inline std::vector<std::byte> body_of(const core::SampleBuffer& sample) {
  const std::byte* body = sample.data + sample.header().body_offset;
  return {body, body + sample.header().body_bytes};
}

/// Sets byte i to i * 31 + i / 256 + seed, so that its value shows its distance from the beginning.
inline void fill_with_distances(std::vector<std::uint8_t>& data, std::uint32_t seed) {
  // Copies blocks, because builds without optimisation run a loop over bytes slowly. 31 * 223 is 1 modulo
  // 256, so each block of 256 bytes has the multiples of 31, shifted by 223 from those of the preceding
  // block.
  constexpr std::size_t row = 256, step = 223;
  constexpr auto multiples = [] {
    std::array<std::uint8_t, 2 * row> twice{};
    for (std::size_t i = 0; i < twice.size(); ++i) twice[i] = static_cast<std::uint8_t>(i * 31);
    return twice;
  }();
  for (std::size_t at = 0; at < data.size(); at += row)
    std::memcpy(&data[at], &multiples[step * (at / row + seed) % row], std::min(data.size() - at, row));
}

/// Returns an image whose data is filled by fill_with_distances().
inline Image make_image(std::size_t data_bytes, std::uint32_t seed = 1) {
  Image image{.stamp = {static_cast<std::int32_t>(seed), 7},
              .name = "camera",
              .height = seed,
              .width = 2,
              .data = {}};
  image.data.resize(data_bytes);
  fill_with_distances(image.data, seed);
  return image;
}

}  // namespace sft::udp::test
