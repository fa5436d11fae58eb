#include "tools/sft/recorded_topic.h"

#include <sys/epoll.h>

#include <algorithm>

#include "tools/recording/qos_profile.h"
#include "tools/recording/sample_type.h"

namespace sft::tool {

namespace {

constexpr std::uint32_t depth_of_recorder = 256;  // the most that shared memory keeps
constexpr std::size_t queue_bytes = std::size_t{256} << 20;
constexpr std::size_t turn_most = 1000;  // samples of a topic before the others have their turn

std::uint64_t to_ns(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

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
  for (const Subscription& one : subscribers_) {
    const SubscriberStatus status = one.subscriber.status();
    for (const SubscriberStatus::Writer& writer : status.writers) {
      const auto source = sources_.find(writer.id);
      if (source == sources_.end() || source->second.offer != one.offer) continue;
      // Shared memory loses nothing but what has no room in the queue of a reader.
      const bool by_queue = writer.connected && writer.transport == TransportKind::shm;
      (by_queue ? counts.lost_by_queue : counts.lost_by_network) += writer.lost;
    }
    const std::uint64_t pushed_out = std::min(status.discarded, counts.lost_by_network);
    counts.lost_by_network -= pushed_out;
    counts.lost_by_queue += pushed_out;
  }
  return counts;
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
  known->second = writer.add_channel(schema_, std::move(channel),
                                     is_retained ? std::max(publisher.qos.history_depth, 1U) : 0);
  return known->second;
}

Result<void> RecordedTopic::follow(const DomainSnapshot::Endpoint& publisher, Node& node, int epoll,
                                   SampleWriter& writer) {
  if (sources_.contains(publisher.id)) return {};
  const Offer offer{publisher.qos.reliability, publisher.qos.durability};
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
  sources_.emplace(publisher.id, Source{channel_of(publisher, writer), offer});
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

void RecordedTopic::take(Subscription& from, SampleWriter& writer, std::optional<std::uint64_t> now_ns) {
  for (std::size_t i = 0; i < turn_most; ++i) {
    const DynamicSample sample = from.subscriber.take();
    if (!sample) return;
    const SampleInfo& info = sample.info();
    auto source = sources_.find(info.writer);
    if (source != sources_.end() && source->second.offer != from.offer) continue;  // it comes by another one
    if (source == sources_.end()) {
      // Its publisher has gone before it was looked for.
      DomainSnapshot::Endpoint unknown;
      unknown.id = info.writer;
      unknown.qos.reliability = from.offer.reliability;
      unknown.qos.durability = from.offer.durability;
      source = sources_.emplace(info.writer, Source{channel_of(unknown, writer), from.offer}).first;
    }
    const std::span<const std::byte> cdr = sample.cdr();
    if (cdr.empty() || sample.mask() != selection_.mask()) {
      ++counts_.lost_by_network;  // malformed, or of a request that is not ours
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
