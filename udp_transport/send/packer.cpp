#include "udp_transport/send/packer.h"

#include <algorithm>
#include <new>

namespace sft::udp {

namespace {
/// The maximum length of a pack in bytes. One system call can send such a pack, whatever the lengths of its
/// samples are.
constexpr std::size_t pack_bytes_most = 44'000;
constexpr std::size_t pack_datagrams = 30;
/// The maximum number of samples in a pack. It is a quarter of the number of samples that a channel keeps.
/// So the next pack can be filled while a pack is not acknowledged.
constexpr std::size_t pack_samples_max = 1024;
/// A sample is packed only if at least this number of such samples fits into a datagram. With fewer samples
/// per datagram, packing would gain little.
constexpr std::size_t samples_per_datagram_min = 4;
}  // namespace

bool Packer::Pack::takes(const core::SampleBuffer& sample, std::size_t bytes) const {
  if (!job->is_pack()) return true;
  return sample.sequence == job->sequence + job->samples() && sample.source_stamp_ns == job->first.stamp_ns &&
         job->samples() < pack_samples_max && job->packed_bytes() + bytes <= pack_bytes_max;
}

Packer::Pack& Packer::pack_for(const Audience& audience) {
  const auto known = std::ranges::find(packs_, &audience, &Pack::audience);
  if (known != packs_.end()) return *known;
  std::size_t datagram_bytes = datagram_bytes_max;
  for (const auto& lane : audience.lanes)
    datagram_bytes = std::min(datagram_bytes, lane->destination().path().datagram_bytes());
  const std::size_t header =
      first_header_bytes + channel_bytes + length_bytes + audience.wire->words.size() * sizeof(std::uint64_t);
  // A sample of at most this length fits into one datagram on every path, so that no packed sample has to be
  // cut.
  const std::size_t sample_bytes = std::min({datagram_bytes_min - header, side_->max_sample_bytes,
                                             (datagram_bytes - header) / samples_per_datagram_min});
  return packs_.emplace_back(Pack{&audience, jobs_->take(), sample_bytes,
                                  std::min(pack_bytes_most, pack_datagrams * datagram_bytes)});
}

Packer::Hold Packer::hold(const Audience& audience, const core::SampleHandle& sample) noexcept try {
  if (!audience.packs || audience.multicast != nullptr) return Hold::unfit;
  if (!projected_) projected_ = jobs_->take();
  detail::Projection& body = projected_->projection;
  if (!encoder_.project(audience, *sample, body)) return Hold::unfit;
  Pack& pack = pack_for(audience);
  if (body.bytes() > pack.sample_bytes_max) return Hold::unfit;
  if (!pack.takes(*sample, body.bytes())) return Hold::full;
  if (!pack.job->is_pack()) {
    encoder_.describe(audience, *sample, *pack.job);
    pack.job->whole_bytes = 0;
  }
  pack.job->pack(body.segments());
  pack.job->whole_bytes += sample->whole_bytes;
  return Hold::held;
} catch (const std::bad_alloc&) {
  return Hold::unfit;
}

}  // namespace sft::udp
