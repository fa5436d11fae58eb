#include "tools/sft/recorded_topic.h"

#include <sys/epoll.h>

#include <algorithm>

#include "tools/recording/qos_profile.h"
#include "tools/recording/sample_type.h"
#include "tools/sft/session.h"

namespace sft::tool {

namespace {

constexpr std::uint32_t depth_of_recorder = 256;  // the maximum depth of a queue in shared memory
constexpr std::uint32_t retained_most = 128;      // PublisherOptions::history_depth
constexpr std::size_t queue_bytes = std::size_t{256} << 20;
constexpr std::size_t turn_most = 1000;  // samples of a topic that are taken before other topics are served

std::uint64_t to_ns(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

/// Returns true if a loss with this transport occurred in the queue of a reader. In shared memory, no other
/// losses are possible.
bool is_queue(TransportKind transport) { return transport == TransportKind::shm; }

}  // namespace

Result<RecordedTopic> RecordedTopic::open(std::string topic, const DynamicType& type,
                                          const std::string& text) {
  const auto named = [&topic](const Error& error) {
    return Error{error.code, "topic '" + topic + "': " + error.message};
  };
  const Result<Selection> selection = recording::selection_of(type, text).map_error(named);
  if (!selection) return tl::unexpected(selection.error());
  Result<recording::SampleType> stored = recording::sample_type(type, selection->mask()).map_error(named);
  if (!stored) return fail(Errc::unavailable, stored.error().message);
  recording::Schema schema{
      .name = std::move(stored->name), .encoding = "ros2msg", .data = std::move(stored->definition)};
  return RecordedTopic(std::move(topic), type, text, *selection, std::move(schema));
}

RecordedTopic::Counts RecordedTopic::counts() const {
  Counts counts = counts_;
  counts.samples -= unwritten_;
  counts.lost_by_disk += unwritten_;
  for (const auto& [id, loss] : losses_)
    (loss.by_queue ? counts.lost_by_queue : counts.lost_by_network) += std::max(loss.before, loss.known);
  std::uint64_t discarded = 0;
  for (const Subscription& one : subscribers_) discarded += one.discarded;
  const std::uint64_t pushed_out = std::min(discarded, counts.lost_by_network);
  counts.lost_by_network -= pushed_out;
  counts.lost_by_queue += pushed_out;
  return counts;
}

void RecordedTopic::look_at_losses(const SampleWriter& writer) {
  for (Subscription& one : subscribers_) {
    const SubscriberStatus status = one.subscriber.status();
    one.discarded = status.discarded;
    for (const SubscriberStatus::Writer& publisher : status.writers) {
      const auto source = sources_.find(publisher.id);
      if (source == sources_.end() || source->second.offer != one.offer) continue;
      if (publisher.lost == 0) continue;
      Loss& loss = losses_[publisher.id];
      loss.known = publisher.lost;
      if (publisher.connected) loss.by_queue = is_queue(publisher.transport);
    }
  }
  unwritten_ = 0;
  for (const auto& [name, channel] : channels_) unwritten_ += writer.lost(channel);
}

std::size_t RecordedTopic::channel_of(const DomainSnapshot::Endpoint& publisher, SampleWriter& writer) {
  const std::string profile = recording::to_profile(publisher.qos);
  const auto [known, is_new] = channels_.try_emplace(publisher.node + '\n' + profile);
  if (!is_new) return known->second;
  recording::Channel channel{.topic = "/" + topic_};
  channel.metadata = {{"offered_qos_profiles", profile}, {"sft_node", publisher.node}};
  if (!text_.empty()) channel.metadata["sft_selection"] = text_;
  const std::string whole = recording::ros_type_name(type_.name());
  if (schema_.name != whole) channel.metadata["sft_type"] = whole;
  const bool is_retained = publisher.qos.durability == transient_local;
  const std::uint32_t depth = publisher.dds ? retained_most : publisher.qos.history_depth;
  known->second =
      writer.add_channel(schema_, std::move(channel), is_retained ? std::clamp(depth, 1U, retained_most) : 0);
  return known->second;
}

Result<void> RecordedTopic::follow(const DomainSnapshot::Endpoint& publisher, Node& node, int epoll,
                                   SampleWriter& writer) {
  const auto known = sources_.find(publisher.id);
  if (known != sources_.end() && !known->second.is_guess) return {};
  const Offer offer{publisher.qos.reliability, requestable_durability(publisher)};
  if (std::ranges::find(subscribers_, offer, &Subscription::offer) == subscribers_.end()) {
    SubscriberOptions options{.reliability = offer.reliability,
                              .durability = offer.durability,
                              .depth = depth_of_recorder,
                              .depth_bytes = queue_bytes,
                              .pollable = true};
    Result<DynamicSubscriber> subscriber =
        node.subscriber("/" + topic_, type_, type_.support().format_selection(selection_), options);
    if (!subscriber) return tl::unexpected(subscriber.error());
    subscribers_.push_back({offer, *std::move(subscriber)});
    epoll_event event{.events = EPOLLIN, .data = {.ptr = this}};
    epoll_ctl(epoll, EPOLL_CTL_ADD, subscribers_.back().subscriber.file_descriptor(), &event);
  }
  Source& source = sources_[publisher.id];
  source.channel = channel_of(publisher, writer);
  source.offer = offer;
  source.is_guess = false;
  return {};
}

void RecordedTopic::take(SampleWriter& writer, std::optional<std::uint64_t> now_ns) {
  for (Subscription& one : subscribers_) take(one, writer, now_ns);
}

void RecordedTopic::discard() {
  for (Subscription& one : subscribers_) {
    if (one.offer.durability == transient_local) continue;
    while (one.subscriber.take()) {
    }
  }
}

/// Returns true if the sample was already taken by another subscription, while its publisher had not been
/// discovered yet. Notes the sample in `source` as long as that is the case.
bool RecordedTopic::is_known(Source& source, std::uint64_t sequence) {
  if (!source.is_guess) {
    const auto found = std::ranges::find(source.taken, sequence);
    const bool is_there = found != source.taken.end();
    if (is_there) source.taken.erase(found);
    return is_there;
  }
  source.taken.push_back(sequence);
  if (source.taken.size() > retained_most) source.taken.pop_front();
  return false;
}

void RecordedTopic::take(Subscription& from, SampleWriter& writer, std::optional<std::uint64_t> now_ns) {
  for (std::size_t i = 0; i < turn_most; ++i) {
    const DynamicSample sample = from.subscriber.take();
    if (!sample) return;
    const SampleInfo& info = sample.info();
    auto source = sources_.find(info.writer);
    // Another subscription takes the sample
    if (source != sources_.end() && source->second.offer != from.offer) continue;
    if (source == sources_.end()) {
      // The publisher has not been discovered yet, or is already gone.
      DomainSnapshot::Endpoint unknown;
      unknown.id = info.writer;
      unknown.qos.reliability = from.offer.reliability;
      unknown.qos.durability = from.offer.durability;
      source = sources_.emplace(info.writer, Source{channel_of(unknown, writer), from.offer, true}).first;
    }
    if (info.lost_before > 0) {
      Loss& loss = losses_[info.writer];
      loss.before += info.lost_before;
      loss.by_queue = is_queue(info.transport);
    }
    if (is_known(source->second, info.sequence)) continue;
    const std::span<const std::byte> cdr = sample.cdr();
    if (cdr.empty() || sample.mask() != selection_.mask()) {
      ++counts_.lost_by_network;  // malformed, or sent for another request
      continue;
    }
    const recording::Message message{.sequence = static_cast<std::uint32_t>(info.sequence),
                                     .log_ns = now_ns.value_or(to_ns(info.receive_stamp)),
                                     .publish_ns = to_ns(info.source_stamp),
                                     .data = cdr};
    if (!writer.put(source->second.channel, message)) {
      ++counts_.lost_by_disk;
      continue;
    }
    ++counts_.samples;
    counts_.bytes += cdr.size();
  }
}

}  // namespace sft::tool
