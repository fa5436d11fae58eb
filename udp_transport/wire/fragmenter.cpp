#include "udp_transport/wire/fragmenter.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

namespace sft::udp {

void Batch::clear() { part_count_ = staged_ = bytes_ = datagrams_ = 0; }

/// Returns memory for `bytes` bytes, which are sent directly after the present content of the batch.
std::byte* Batch::stage(std::size_t bytes) {
  std::byte* place = staging_.get() + staged_;
  const bool extends =
      part_count_ > 0 &&
      static_cast<std::byte*>(parts_[part_count_ - 1].iov_base) + parts_[part_count_ - 1].iov_len == place;
  if (extends) {
    parts_[part_count_ - 1].iov_len += bytes;
  } else {
    assert(part_count_ < parts_max);
    parts_[part_count_++] = {place, bytes};
  }
  staged_ += bytes;
  bytes_ += bytes;
  return place;
}

/// Pads the last datagram of the batch to full length. Called before a further datagram is appended.
void Batch::pad() {
  const std::size_t missing = datagrams_ * segment_bytes_ - bytes_;
  if (missing > 0) std::memset(stage(missing), 0, missing);
}

void Batch::refer(const std::byte* data, std::size_t bytes) {
  assert(part_count_ < parts_max);
  // The cast is safe, because the data is only read.
  parts_[part_count_++] = {const_cast<std::byte*>(data), bytes};
  bytes_ += bytes;
}

Fragmenter::Fragmenter(const EncodedBody& body, std::size_t datagram_bytes, BodyRange range)
    : body_(body),
      datagram_bytes_(std::min(datagram_bytes, datagram_bytes_max)),
      end_(std::min(range.end, body.first.total)) {
  assert(datagram_bytes_ > body_.first.bytes() + body_.mask_words.size_bytes());
  if (range.begin > 0) skip(std::min(range.begin, end_));
  if (!body_.packed || body_.segments.empty()) return;
  const std::size_t bytes = body_.segments.front().bytes;
  if (std::ranges::all_of(body_.segments,
                          [&](const detail::Segment& sample) { return sample.bytes == bytes; }))
    bytes_each_ = bytes;
}

void Fragmenter::skip(std::size_t bytes) {
  begun_ = true;
  offset_ = static_cast<std::uint32_t>(bytes);
  while (segment_ < body_.segments.size() && bytes >= body_.segments[segment_].bytes)
    bytes -= body_.segments[segment_++].bytes;
  segment_offset_ = bytes;
}

void Fragmenter::next(Batch& batch, std::size_t bytes_max, std::size_t datagrams_max) {
  batch.clear();
  batch.segment_bytes_ = static_cast<std::uint16_t>(datagram_bytes_);
  bytes_max = std::min(bytes_max, batch_bytes_max);
  datagrams_max = std::min(datagrams_max, batch_datagrams_max);
  do {
    body_.packed ? append_packed(batch) : append_datagram(batch);
  } while (!done() && batch.datagrams_ < datagrams_max && bytes_with_next(batch) <= bytes_max);
}

/// Returns the length of the batch after one more datagram.
std::size_t Fragmenter::bytes_with_next(const Batch& batch) const {
  if (body_.packed) return batch.datagrams_ * batch.segment_bytes_ + next_pack().bytes;
  const std::size_t header = FollowingHeader{body_.first.label, offset_}.bytes();
  return batch.bytes_ + std::min<std::size_t>(datagram_bytes_, header + end_ - offset_);
}

void Fragmenter::append_datagram(Batch& batch) {
  const std::size_t before = batch.bytes_;
  const std::uint32_t end = begun_ ? end_ : body_.first.total;
  append_header(batch);
  const std::size_t room = datagram_bytes_ - (batch.bytes_ - before);
  append_payload(batch, std::min<std::size_t>(room, end - offset_));
  ++batch.datagrams_;
}

void Fragmenter::append_header(Batch& batch) {
  const FirstHeader& first = body_.first;
  if (std::exchange(begun_, true)) {
    const FollowingHeader following{first.label, offset_};
    return encode(following, batch.stage(following.bytes()));
  }
  const std::size_t words = body_.mask_words.size_bytes();
  if (first.bytes_in_short() + words + first.total <= datagram_bytes_ && fits_in_short(first)) {
    encode_in_short(first, batch.stage(first.bytes_in_short()));
  } else if (first.bytes_in_single() + first.total <= datagram_bytes_ && fits_in_single(first)) {
    encode_in_single(first, batch.stage(first.bytes_in_single()));
  } else {
    encode(first, batch.stage(first.bytes()));
  }
  append_mask_words(batch);
}

void Fragmenter::append_mask_words(Batch& batch) const {
  for (const std::uint64_t word : body_.mask_words) store_word(word, batch.stage(sizeof word));
}

/// Returns the next pack: as many samples as fit into a datagram, but at least one.
Fragmenter::Pack Fragmenter::next_pack() const {
  const std::size_t header = body_.first.bytes() + body_.mask_words.size_bytes();
  const std::size_t most = std::min(packed_samples_max, body_.segments.size() - segment_);
  if (bytes_each_ != 0) {
    const std::size_t fit = (datagram_bytes_ - header) / bytes_each_;
    const std::size_t samples = std::clamp<std::size_t>(fit, 1, most);
    return {samples, header + samples * bytes_each_};
  }
  Pack pack{0, header};
  while (pack.samples < most) {
    const std::size_t bytes = length_bytes + body_.segments[segment_ + pack.samples].bytes;
    if (pack.samples > 0 && pack.bytes + bytes > datagram_bytes_) break;
    pack.bytes += bytes;
    ++pack.samples;
  }
  return pack;
}

/// Appends a packed datagram. All datagrams of a batch except the last must have the same length, so shorter
/// datagrams are padded with zeros.
void Fragmenter::append_packed(Batch& batch) {
  if (batch.datagrams_ > 0) batch.pad();
  const Pack pack = next_pack();
  PackedHeader header{header_behind(body_.first, static_cast<std::uint32_t>(segment_), 0),
                      static_cast<std::uint16_t>(pack.samples), static_cast<std::uint16_t>(bytes_each_)};
  if (bytes_each_ == 0) header.first.flags |= lengths_follow;
  encode(header, batch.stage(header.first.bytes()));
  append_mask_words(batch);
  for (const detail::Segment& sample : body_.segments.subspan(segment_, pack.samples)) {
    if (bytes_each_ == 0) store_length(sample.bytes, batch.stage(length_bytes));
    if (sample.bytes > 0) std::memcpy(batch.stage(sample.bytes), sample.data, sample.bytes);
  }
  segment_ += pack.samples;
  if (batch.datagrams_++ == 0 && bytes_each_ != 0)
    batch.segment_bytes_ = static_cast<std::uint16_t>(pack.bytes);
}

void Fragmenter::append_payload(Batch& batch, std::size_t bytes) {
  offset_ += static_cast<std::uint32_t>(bytes);
  while (bytes > 0) {
    assert(segment_ < body_.segments.size());
    const detail::Segment& segment = body_.segments[segment_];
    const std::size_t run = std::min(bytes, segment.bytes - segment_offset_);
    const std::byte* data = segment.data + segment_offset_;
    if (run >= copy_bytes_max) {
      batch.refer(data, run);
    } else {
      std::memcpy(batch.stage(run), data, run);
    }
    bytes -= run;
    segment_offset_ += run;
    if (segment_offset_ == segment.bytes) {
      ++segment_;
      segment_offset_ = 0;
    }
  }
}

}  // namespace sft::udp
