// These checks must hold in the world after each event, and in the end.
#include <algorithm>
#include <span>
#include <string>

#include "tests/simulation/udp/world.h"

namespace sft::simulation {

/// Returns true if the sample is what was published, under its mask.
bool World::is_sound(const core::SampleBuffer& sample, const std::string& which) {
  if (sample.writer != writer_id) return fail(which + " names another writer"), false;
  const auto image = images_.find(sample.sequence);
  if (image == images_.end()) return fail(which + " was never published"), false;
  const std::span<const std::byte> body(sample.data + sample.header().body_offset,
                                        sample.header().body_bytes);
  if (std::ranges::equal(body, udp::test::encoded_body(image->second, sample.mask))) return true;
  return fail(which + " has other bytes, or those of another mask"), false;
}

void World::check_limits() {
  if (window_->kept() > scenario_.resend.samples) fail("the writer keeps too many samples");
  if (window_->kept_bytes() > scenario_.resend.bytes && window_->kept() > 1)
    fail("the writer keeps too much");
  if (reassembly_ == nullptr) return;
  udp::ArrivalWindow& arrivals = *reassembly_->window(0);
  if (arrivals.samples().slots().size() > scenario_.reassembly.channel.samples)
    fail("the reader keeps too many places");
  const udp::ArrivalLimits& limits = scenario_.reassembly.channel;
  const std::size_t buffer_bytes_max = 2 * scenario_.sample_bytes_max;
  const std::size_t most = scenario_.readers_lag ? limits.awaited_bytes + buffer_bytes_max
                                                 : limits.held_bytes + scenario_.sample_bytes_max;
  if (arrivals.samples().held_bytes() > most) fail("the reader holds back too much");
  if (!forgers_) check_losses();
}

/// The process was told of each lost sample once, the oldest first: all of them lie before what may still
/// come.
void World::check_losses() {
  udp::ArrivalWindow& arrivals = *reassembly_->window(0);
  const auto mark = arrivals.mark();
  if (arrivals.samples().lost() == lost_ || !mark) return;
  lost_ = arrivals.samples().lost();
  std::uint64_t missing = 0;
  for (const auto& [number, channel] : channels_) {
    const bool present = number == mark->channel;
    const std::uint64_t next = present ? std::max(arrivals.samples().next(), channel.base) - channel.base : 0;
    missing += missing_of(channel, std::max(next, channel.gone_before));
  }
  if (missing != lost_)
    fail(std::to_string(lost_) + " are said to be lost, and " + std::to_string(missing) + " did not come");
}

/// Returns how many samples are missing of those that the process knows of, up to `end`.
std::uint64_t World::missing_of(const Channel& channel, std::uint64_t end) const {
  if (!channel.known_from) return 0;
  std::uint64_t missing = 0;
  for (auto i = channel.sent.lower_bound(*channel.known_from); i != channel.sent.end() && i->first < end; ++i)
    missing += came_at_once_.contains(i->second) || unwanted_.contains(i->second) ? 0 : 1;
  return missing;
}

/// Nothing is under way any more.
void World::check_end() {
  if (readers_.empty()) return;
  if (!window_->settled()) fail("the writer waits for an ack that does not come");
  const Channel& before = channels_[channel_ - 1];
  const std::uint64_t missing =
      missing_of(before, before.gone_before) + missing_of(channels_[channel_], UINT64_MAX);
  if (missing != lost_ && !forgers_)
    fail(std::to_string(missing) + " did not come, and " + std::to_string(lost_) + " are said to be lost");
  for (const Reader& reader : readers_) check_end(reader);
}

/// A forged sample that claimed a place in the future has taken it from the true one: nobody can tell them
/// apart. There are few of these.
void World::check_end_after_forgeries(const Reader& reader) {
  std::size_t owed = 0, missing = 0;
  for (const Variant& sample : reader.to_get) {
    if (sample.sequence < first_owed_ || not_kept_.contains(sample.sequence)) continue;
    ++owed;
    missing += reader.got.contains(sample.sequence) ? 0 : 1;
  }
  if (owed < 50) fail("it was not looked at for long enough");
  if (100 * missing > owed)
    fail(std::to_string(missing) + " of " + std::to_string(owed) + " samples did not come");
}

void World::check_end(const Reader& reader) {
  if (forgers_) return check_end_after_forgeries(reader);
  for (const Variant& sample : reader.to_get) {
    if (reader.got.contains(sample.sequence)) continue;
    const std::string which =
        "sample " + std::to_string(sample.sequence) + " of reader " + std::to_string(reader.id);
    if (unwanted_.contains(sample)) return fail(which + " came, and was refused");
    if (came_at_once_.contains(sample)) return fail(which + " came, and was not handed over");
    if (not_kept_.contains(sample.sequence)) continue;
    if (!scenario_.tight_reader) return fail(which + " did not come");
    if (came_at_once_.lower_bound({sample.sequence, 0}) == came_at_once_.end())
      return fail(which + " is lost, and nothing behind it came");
  }
}

}  // namespace sft::simulation
