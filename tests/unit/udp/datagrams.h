// Functions that make datagrams with the bytes that a sender would send.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/seam/transport.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp::test {

using Bytes = std::vector<std::byte>;

/// The writer of the samples in tests with one writer.
inline constexpr core::EndpointId lone_writer = 0xaaaa'bbbb'0000'0001;
inline constexpr std::uint32_t short_id = static_cast<std::uint32_t>(lone_writer);

inline void append_datagrams(std::span<const iovec> parts, std::size_t segment_bytes,
                             std::vector<Bytes>& out) {
  Bytes all;
  for (const iovec& part : parts) {
    const auto* data = static_cast<const std::byte*>(part.iov_base);
    all.insert(all.end(), data, data + part.iov_len);
  }
  const std::size_t segment = segment_bytes == 0 ? all.size() : segment_bytes;
  for (std::size_t at = 0; at < all.size(); at += segment) {
    const std::size_t end = std::min(at + segment, all.size());
    out.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                     all.begin() + static_cast<std::ptrdiff_t>(end));
  }
}

inline std::vector<Bytes> cut(const EncodedBody& body, std::size_t datagram_bytes) {
  std::vector<Bytes> datagrams;
  Batch batch;
  Fragmenter fragments(body, datagram_bytes);
  while (!fragments.done()) {
    fragments.next(batch);
    append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
  }
  return datagrams;
}

/// Returns all datagrams of one sample of `value`, encoded with `mask`.
template <class T>
std::vector<Bytes> datagrams_of(const T& value, const FieldMask& mask, SampleLabel label,
                                std::size_t datagram_bytes = 1472) {
  const Bytes body = encoded_body(value, mask);
  const detail::Segment whole{body.data(), body.size()};
  std::vector<std::uint64_t> words;
  for (std::size_t i = 0; mask.words() > 1 && i < mask.words(); ++i) words.push_back(mask.word(i));
  FirstHeader first{.label = label, .flags = 0, .total = 0, .mask = mask.hash(), .stamp_ns = 5};
  first.flags = words.empty() ? std::uint8_t{0} : mask_words_follow;
  first.total = static_cast<std::uint32_t>(body.size());
  return cut({first, words, {&whole, 1}}, datagram_bytes);
}

}  // namespace sft::udp::test
