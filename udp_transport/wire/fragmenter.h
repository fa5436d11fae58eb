// Cuts one encoded body into datagrams, and arranges them without gaps, so that one system call can send
// them (GSO). Uses no clock, thread or I/O.
#pragma once

#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "sft/detail/project.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// The limits of one system call, also for older kernels.
inline constexpr std::size_t batch_bytes_max = datagram_bytes_max;
inline constexpr std::size_t batch_datagrams_max = 64;

/// If a contiguous run of a body is shorter than this number of bytes, it is copied after the header that
/// precedes it. Copying costs less than a separate iovec.
inline constexpr std::size_t copy_bytes_max = 2048;

/// Datagrams for one system call. The batch contains the headers and short runs of the body. For longer
/// runs, it refers to the body.
class Batch {
 public:
  Batch() : staging_(new std::byte[batch_bytes_max]) {}  // its pages are only touched when they are needed

  std::span<const iovec> parts() const { return {parts_.data(), part_count_}; }
  std::size_t bytes() const { return bytes_; }
  std::size_t datagrams() const { return datagrams_; }
  /// Returns the length of the longest datagram.
  std::size_t longest() const { return datagrams_ > 1 ? segment_bytes_ : bytes_; }
  /// Returns the length of all datagrams but the last one; 0 if there is only one datagram.
  std::uint16_t segment_bytes() const { return datagrams_ > 1 ? segment_bytes_ : std::uint16_t{0}; }

 private:
  friend class Fragmenter;
  void clear();
  void pad();
  std::byte* stage(std::size_t bytes);
  void refer(const std::byte* data, std::size_t bytes);

  // A part is either staged bytes or a run of at least copy_bytes_max bytes. Two consecutive parts are never
  // both staged.
  static constexpr std::size_t parts_max = 2 * (batch_bytes_max / copy_bytes_max) + 1;
  std::array<iovec, parts_max> parts_;
  std::size_t part_count_ = 0;
  std::unique_ptr<std::byte[]> staging_;
  std::size_t staged_ = 0;
  std::size_t bytes_ = 0;
  std::size_t datagrams_ = 0;
  std::uint16_t segment_bytes_ = 0;
};

/// A body, and the header that its datagrams get. The spans must outlive the fragmenter.
struct EncodedBody {
  FirstHeader first;                          ///< the header; its `total` is the length of the body in bytes
  std::span<const std::uint64_t> mask_words;  ///< sent only if the header has the flag mask_words_follow
  std::span<const detail::Segment> segments;
  /// True if each segment is a small sample, and the samples have consecutive sequences. They are sent in
  /// packed datagrams.
  bool packed = false;
};

/// The range [begin, end) of bytes of a body. If `begin` is 0, the range always includes the whole first
/// datagram.
struct BodyRange {
  std::uint32_t begin = 0;
  std::uint32_t end = UINT32_MAX;
  friend bool operator==(const BodyRange&, const BodyRange&) = default;
};

class Fragmenter {
 public:
  Fragmenter(const EncodedBody& body, std::size_t datagram_bytes, BodyRange range = {});

  std::size_t bytes() const { return body_.first.total; }  ///< length of the body in bytes
  bool begun() const { return begun_; }
  /// Returns the offset in the body up to which datagrams have been cut.
  std::uint32_t offset() const { return offset_; }
  bool done() const { return body_.packed ? segment_ == body_.segments.size() : begun_ && offset_ >= end_; }

  /// Sets the maximum length of further datagrams.
  void set_datagram_bytes(std::size_t bytes) { datagram_bytes_ = std::min(bytes, datagram_bytes_max); }

  /// Replaces the content of `batch` by the next datagrams. The batch gets at least one datagram, even if
  /// that exceeds `bytes_max`.
  void next(Batch& batch, std::size_t bytes_max = batch_bytes_max,
            std::size_t datagrams_max = batch_datagrams_max);

 private:
  void skip(std::size_t bytes);
  std::size_t bytes_with_next(const Batch& batch) const;
  void append_datagram(Batch& batch);
  void append_header(Batch& batch);
  void append_payload(Batch& batch, std::size_t bytes);
  void append_mask_words(Batch& batch) const;

  struct Pack {
    std::size_t samples = 0;
    std::size_t bytes = 0;  ///< length of the datagram
  };
  Pack next_pack() const;
  void append_packed(Batch& batch);

  EncodedBody body_;
  std::size_t datagram_bytes_;
  std::uint32_t end_;
  bool begun_ = false;
  std::uint32_t offset_ = 0;  ///< offset of the next payload in the body
  std::size_t segment_ = 0;
  std::size_t segment_offset_ = 0;
  std::size_t bytes_each_ = 0;  ///< length of each packed sample; 0: lengths differ
};

}  // namespace sft::udp
