#include "tools/sft/bridge_flow.h"

#include <sft/json.h>
#include <sys/epoll.h>

#include <algorithm>

#include "tools/recording/sample_type.h"

namespace sft::tool {

namespace {

using namespace std::chrono_literals;
using Verdict = BridgeRoutes::Verdict;

constexpr std::uint32_t bridge_retained_most = 128;  // PublisherOptions::history_depth
constexpr std::uint32_t retained_if_unknown = 16;    // used if a writer of DDS does not announce a depth
constexpr std::uint32_t depth_of_bridge = 128;
constexpr std::size_t early_most = 128;
constexpr auto linger = 2s;  // samples of a publisher may arrive until this time after it was last seen
// Subscriptions are kept for this time after the last publisher is gone. If an interrupted network link
// works again within that time, samples arrive at once.
constexpr auto outage_time = 15min;
constexpr auto reader_time = 2s;  // readers on the other side find a new publisher within this time
constexpr std::size_t turn_samples = 64, turn_bytes = 1 << 20;  // carried before other topics are served

/// Returns the maximum number of bytes of early samples. It limits the time that samples take after a pause
/// of the network: 4 MiB take 0.7 s at 50 Mbit/s.
constexpr std::size_t kept_bytes(Durability durability) {
  return std::size_t{durability == transient_local ? 64U : 4U} << 20;
}

/// Returns an error that names the fields that are left out, although a message of the type has them.
Result<void> check_fields(const TypeSupport& type, const FieldMask& sent, const BridgeRuleOptions& options) {
  FieldMask missing = type.full() - sent;
  for (const std::string& fields : options.defaults) {
    // `options` of the command line hold for all rules. So a field in them may belong to another type.
    if (const Result<FieldMask> zero = type.parse_mask(fields)) missing -= *zero;
  }
  if (missing.empty()) return {};
  return fail(Errc::invalid_argument,
              "a message of type " + std::string(type.name()) + " cannot lack '" + type.format_mask(missing) +
                  "': select it, or name it in --defaults if it may be zero or empty there");
}

}  // namespace

Result<BridgeFlow> BridgeFlow::open(const BridgeRule& rule, std::string topic, std::string target,
                                    const DynamicType& type, int epoll, Counts& counts) {
  const Result<Selection> selection = recording::selection_of(type, rule.selection);
  if (!selection) return tl::unexpected(selection.error());
  const Result<void> complete = check_fields(type.support(), selection->mask(), rule.options);
  if (!complete) return tl::unexpected(complete.error());
  return BridgeFlow(rule, std::move(topic), std::move(target), type, *selection, epoll, counts);
}

Result<void> BridgeFlow::look(BridgeEnd& from, BridgeEnd& to, Time now,
                              std::vector<BridgeRoutes::Route>& here,
                              std::vector<BridgeRoutes::Route>& there) {
  Result<void> all;
  find_sources(from, now);
  std::erase_if(sources_, [&](const auto& one) { return now - one.second.seen > linger; });
  if (!sources_.empty()) had_sources_ = now;
  for (auto& [id, source] : sources_) {
    if (!source.is_known) continue;
    if (source.is_dds) here.push_back({.origin = id, .topic = topic_});
    const bool is_served_already = std::ranges::any_of(there, [&](const BridgeRoutes::Route& route) {
      return source.origin && route.origin == source.origin->origin && route.topic == target_;
    });
    source.verdict = !source.origin      ? Verdict::settles
                     : is_served_already ? Verdict::held_by_another
                                         : to.routes.verdict(*source.origin, target_, now);
    if (const Result<void> done = decide(source, to, now); !done) all = done;
    if (!source.origin || is_served_already || source.verdict == Verdict::belongs_there) continue;
    there.push_back({.origin = source.origin->origin,
                     .bridges = source.origin->bridges + 1,
                     .topic = target_,
                     .publisher = source.publisher ? source.publisher_id : 0});
  }
  return all.and_then([&] { return subscribe(from.node, now); });
}

void BridgeFlow::find_sources(const BridgeEnd& from, Time now) {
  for (const DomainSnapshot::Endpoint& publisher : from.domain.publishers) {
    const bool is_dds = publisher.dds.has_value();
    const bool has_type = is_dds ? publisher.type_name == type_.name() : publisher.type_hash == type_.hash();
    if (publisher.is_own || !has_type || publisher.topic != topic_) continue;
    Source& source = sources_[publisher.id];
    if (!source.is_known) {
      source.qos = publisher.qos;
      // DDS gives retained samples to reliable readers only.
      if (is_dds && source.qos.reliability == best_effort) source.qos.durability = volatile_;
    }
    source.is_known = true;
    source.is_dds = is_dds;
    source.seen = now;
    source.origin = from.routes.source_of(publisher);
  }
}

Result<void> BridgeFlow::decide(Source& source, BridgeEnd& to, Time now) {
  if (source.verdict != Verdict::holds) {
    source.publisher.reset();
    source.is_read = false;
    if (source.verdict == Verdict::settles) return {};
    source.early.clear();
    source.early_bytes = 0;
    return {};
  }
  if (!source.publisher) {
    if (const Result<void> begun = begin(source, to.node, now); !begun) return begun;
  }
  const PublisherStatus status = source.publisher->status();
  source.is_read = status.vanilla_readers > 0 ||
                   std::ranges::any_of(status.readers, [&](const PublisherStatus::Reader& reader) {
                     return reader.served && reader.node != to.node_name;
                   });
  if (source.is_read || source.is_retained() || now - source.opened > reader_time) pass_on_early(source);
  return {};
}

Result<void> BridgeFlow::begin(Source& source, Node& node, Time now) {
  const std::uint32_t depth = source.qos.history_depth;
  const bool has_conditions = rule_->selection.find('@') != std::string::npos;
  const Reliability reliability = rule_->options.reliable ? reliable : source.qos.reliability;
  const PublisherOptions options{
      .reliability = reliability,
      .durability = source.qos.durability,
      .history_depth = !source.is_retained() ? 1
                       : depth == 0          ? retained_if_unknown
                                             : std::min(depth, bridge_retained_most),
      .deadline = has_conditions ? std::chrono::nanoseconds(0) : source.qos.deadline,
      .lifespan = source.qos.lifespan,
      .resend_bytes =
          reliability == reliable ? kept_bytes(source.qos.durability) : PublisherOptions{}.resend_bytes,
      .priority = rule_->options.priority,
      .asynchronous = true};
  Result<DynamicPublisher> publisher = node.publisher("/" + target_, type_, options);
  if (!publisher) return tl::unexpected(publisher.error());
  source.publisher.emplace(*std::move(publisher));
  source.publisher_id = source.publisher->status().id;
  source.opened = now;
  source.sequence = 0;
  // A new subscription receives the retained samples, unless they are among the early ones.
  if (source.is_retained() && source.early.empty()) close(source.offer());
  return {};
}

std::vector<BridgeFlow::Offer> BridgeFlow::wanted_offers() const {
  std::vector<Offer> wanted;
  for (const auto& [id, source] : sources_) {
    if (source.publisher && (source.is_read || source.is_retained())) wanted.push_back(source.offer());
  }
  return wanted;
}

/// Returns true if the subscription for this offer is not needed, unless wanted_offers() contains the
/// offer. This is the case if a publisher with this offer has been discovered, and either its route must
/// not be used, or the publisher of the bridge is old enough that its readers are known.
bool BridgeFlow::is_unwanted(const Offer& offer, Time now) const {
  return std::ranges::any_of(sources_, [&](const auto& one) {
    const Source& source = one.second;
    return source.is_known && source.offer() == offer &&
           (source.publisher ? now - source.opened > reader_time : source.verdict != Verdict::settles);
  });
}

bool BridgeFlow::is_over(Time now) const {
  return sources_.empty() && (subscriptions_.empty() || now - had_sources_ > outage_time);
}

Result<void> BridgeFlow::subscribe(Node& node, Time now) {
  const std::vector<Offer> wanted = wanted_offers();
  std::vector<Offer> unwanted;
  for (const Subscription& one : subscriptions_) {
    if (std::ranges::find(wanted, one.offer) == wanted.end() && is_unwanted(one.offer, now))
      unwanted.push_back(one.offer);
  }
  for (const Offer& offer : unwanted) close(offer);
  for (const Offer& offer : wanted) {
    if (std::ranges::find(subscriptions_, offer, &Subscription::offer) != subscriptions_.end()) continue;
    const SubscriberOptions options{.reliability = offer.reliability,
                                    .durability = offer.durability,
                                    .depth = depth_of_bridge,
                                    .depth_bytes = kept_bytes(offer.durability),
                                    .pollable = true};
    Result<DynamicSubscriber> subscriber =
        node.subscriber("/" + topic_, type_, type_.support().format_selection(selection_), options);
    if (!subscriber) return tl::unexpected(subscriber.error());
    subscriptions_.push_back({offer, *std::move(subscriber)});
    epoll_event event{.events = EPOLLIN, .data = {.ptr = this}};
    epoll_ctl(epoll_, EPOLL_CTL_ADD, subscriptions_.back().subscriber.file_descriptor(), &event);
  }
  return {};
}

void BridgeFlow::close(const Offer& offer) {
  const auto one = std::ranges::find(subscriptions_, offer, &Subscription::offer);
  if (one == subscriptions_.end()) return;
  epoll_ctl(epoll_, EPOLL_CTL_DEL, one->subscriber.file_descriptor(), nullptr);
  subscriptions_.erase(one);
}

void BridgeFlow::carry() {
  const Time now = std::chrono::steady_clock::now();
  for (Subscription& one : subscriptions_) {
    const std::uint64_t before = counts_->bytes;
    for (std::size_t i = 0; i < turn_samples && counts_->bytes - before < turn_bytes; ++i) {
      DynamicSample sample = one.subscriber.take();
      if (!sample) break;
      take(one.offer, std::move(sample), now);
    }
  }
}

void BridgeFlow::take(const Offer& offer, DynamicSample&& sample, Time now) {
  const auto [known, is_new] = sources_.try_emplace(sample.info().writer);
  Source& source = known->second;
  if (is_new) source.seen = now;
  if (source.is_known && source.offer() != offer) return;  // another subscription receives these samples
  if (source.publisher && source.early.empty()) return pass_on(source, sample);
  if (source.verdict != Verdict::settles && !source.publisher) return;
  source.early_bytes += sample.cdr().size();
  source.early.emplace_back(offer, std::move(sample));
  while (source.early.size() > 1 &&
         (source.early.size() > early_most || source.early_bytes > kept_bytes(offer.durability))) {
    source.early_bytes -= source.early.front().second.cdr().size();
    source.early.pop_front();
    ++counts_->lost;
  }
}

void BridgeFlow::pass_on_early(Source& source) {
  for (const auto& [offer, sample] : source.early) {
    if (offer == source.offer()) pass_on(source, sample);
  }
  source.early.clear();
  source.early_bytes = 0;
}

void BridgeFlow::pass_on(Source& source, const DynamicSample& sample) {
  const SampleInfo& info = sample.info();
  if (info.sequence <= source.sequence) return;  // a new subscription has received the sample again
  source.sequence = info.sequence;
  if (!source.is_read && !source.is_retained()) return;
  counts_->lost += info.lost_before;
  if (sample.mask() != selection_.mask())
    return refuse("a sample does not have the fields that were selected");
  std::span<const std::byte> cdr = sample.cdr();
  std::vector<std::byte> completed;
  if (!selection_.mask().is_full()) {
    Result<std::vector<std::byte>> whole =
        sample.to_json().and_then([&](const std::string& json) { return cdr_from_json(type_.type(), json); });
    if (!whole) return refuse(whole.error().message);
    cdr = completed = *std::move(whole);
  }
  if (cdr.empty()) return refuse("a sample is malformed");
  const Result<PublishStatus> done = source.publisher->publish_cdr(cdr, info.source_stamp);
  if (!done) return refuse(done.error().message);
  if (*done != PublishStatus::ok) {
    ++counts_->lost;
    return;
  }
  ++counts_->carried;
  counts_->bytes += cdr.size();
  sample_bytes_ = cdr.size();
}

void BridgeFlow::refuse(const std::string& why) {
  ++counts_->refused;
  if (faults_.size() < early_most && faults_.insert(why).second) fault_ = why;
}

BridgeFlow::State BridgeFlow::state() const {
  State state;
  for (const auto& [id, source] : sources_) {
    if (!source.is_known) continue;
    ++state.publishers;
    state.carried += source.publisher ? 1 : 0;
    state.read += source.is_read ? 1 : 0;
    state.is_held_by_another |= source.verdict == Verdict::held_by_another;
  }
  return state;
}

}  // namespace sft::tool
