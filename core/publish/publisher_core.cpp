#include "core/publish/publisher_core.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/platform/clock.h"

namespace sft::core {

namespace {

/// The maximum number of samples of a span that are sent within one Call. The agent waits for a Call when
/// it changes the outlets, so this limits the time that it waits.
constexpr std::size_t span_at_once = 1024;

bool equal_but_for_number(PublisherStatus::Reader a, const PublisherStatus::Reader& b) {
  a.request_sequence = b.request_sequence;
  return a == b;
}

}  // namespace

PublisherCore::PublisherCore(Spec spec, std::shared_ptr<BufferPool> heap,
                             std::shared_ptr<NetworkWriter> network)
    : spec_(std::move(spec)),
      network_(std::move(network)),
      history_(spec_.qos.durability == Durability::volatile_
                   ? nullptr
                   : std::make_unique<History>(spec_.qos.history_depth, spec_.qos.lifespan.count())),
      maker_({spec_.id, spec_.topic, spec_.type, spec_.max_sample_bytes, spec_.refused}, std::move(heap)),
      dispatch_(
          {spec_.type, network_, spec_.book, history_.get(), spec_.max_blocking.count() > 0, spec_.topic}),
      late_readers_(*spec_.type, network_, spec_.book, history_.get()),
      events_(spec_.on_event, spec_.callbacks),
      readers_changed_(spec_.on_readers_changed, spec_.callbacks),
      encoded_(spec_.type->none()) {}

void PublisherCore::serve(Serving serving, std::shared_ptr<LendingWriter> memory,
                          std::shared_ptr<VanillaPort> vanilla) {
  const FieldMask encoded = dispatch_.serve(serving, memory, vanilla);
  late_readers_.serve(serving, std::move(memory));
  std::set<EndpointId> known;
  for (const PublisherStatus::Reader& reader : serving.readers) known.insert(reader.id);
  spec_.book->keep(known);
  {
    const Lock lock(status_mutex_);
    readers_ = std::move(serving.readers);
    encoded_ = encoded;
    const bool is_new = std::exchange(vanilla_, vanilla) != vanilla;
    if (!is_new) vanilla = nullptr;
  }
  if (vanilla != nullptr) {
    vanilla->begin_with(history_ == nullptr ? std::vector<SampleHandle>()
                                            : history_->last(spec_.qos.history_depth, realtime_ns()));
  }
  readers_known_.notify_all();
  if (readers_changed_.is_set()) readers_changed_(status());
}

void PublisherCore::show(std::vector<PublisherStatus::Reader> readers) {
  bool is_news = false;
  {
    const Lock lock(status_mutex_);
    is_news = !std::ranges::equal(readers_, readers, equal_but_for_number);
    readers_ = std::move(readers);
  }
  readers_known_.notify_all();
  if (is_news && readers_changed_.is_set()) readers_changed_(status());
}

/// A thread that waits either sees the new number, or sleeps already once the lock is free.
void PublisherCore::vanilla_readers_changed() {
  { const Lock lock(status_mutex_); }
  readers_known_.notify_all();
  if (readers_changed_.is_set()) readers_changed_(status());
}

PublishStatus PublisherCore::publish(const detail::Message& message) {
  const Dispatch::Call call(dispatch_);
  if (!maker_.accepts(call.outlets(), message)) return PublishStatus::invalid;
  if (!call.outlets().is_wanted) return dispatch_.withhold();
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  return publish_one(call, message, realtime_ns(), timeout);
}

PublishStatus PublisherCore::publish_one(const Dispatch::Call& call, const detail::Message& message,
                                         std::int64_t stamp_ns, std::chrono::nanoseconds& timeout) {
  const auto fields = &message.type == &spec_.type->type() ? detail::FieldSource::of_message(message.value)
                                                           : detail::FieldSource::of_other_struct(message);
  Dispatch::Admission admission = dispatch_.admit(fields, stamp_ns);
  if (!admission.passes) return dispatch_.withhold();
  const SampleMaker::Made made = maker_.encode(call.outlets(), message, dispatch_.may_postpone(), timeout);
  if (!made.sample) [[unlikely]] {
    if (made.why_not == PublishStatus::no_memory)
      return dispatch_.miss(std::move(admission), made.body_bytes);
    dispatch_.refuse();
    return made.why_not;
  }
  dispatch_.made(fields, stamp_ns);
  const PublishStatus status = dispatch_.send(made.sample, stamp_ns, std::move(admission), timeout);
  maker_.sent(*made.sample);
  return status;
}

PublishedSpan PublisherCore::publish(const void* values, std::size_t count, std::size_t stride) {
  const auto* value = static_cast<const std::byte*>(values);
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  PublishedSpan all;
  BatchTimeout share = BatchTimeout::fresh;
  while (count > 0) {
    const std::size_t some = std::min(count, span_at_once);
    const PublishedSpan published = publish_some(value, some, stride, share, timeout);
    share = BatchTimeout::continued;
    all.published += published.published;
    if (all.status == PublishStatus::ok) all.status = published.status;
    value += some * stride;
    count -= some;
  }
  return all;
}

/// Publishes values within one Dispatch::Call.
PublishedSpan PublisherCore::publish_some(const std::byte* values, std::size_t count, std::size_t stride,
                                          BatchTimeout share, std::chrono::nanoseconds& timeout) {
  const Dispatch::Call call(dispatch_);
  const bool is_wanted = call.outlets().is_wanted;
  const std::int64_t stamp_ns = is_wanted ? realtime_ns() : 0;
  PublishedSpan done;
  std::optional<Batch> batch = is_wanted ? dispatch_.batch(share) : std::nullopt;
  for (std::size_t i = 0; i < count; ++i) {
    const detail::Message message{spec_.type->type(), values + i * stride};
    const PublishStatus status = !maker_.accepts(call.outlets(), message) ? PublishStatus::invalid
                                 : is_wanted ? publish_one(call, message, stamp_ns, timeout)
                                             : dispatch_.withhold();
    done.published += status == PublishStatus::ok ? 1 : 0;
    if (done.status == PublishStatus::ok) done.status = status;
  }
  const std::size_t missed = batch ? std::min((*std::move(batch)).flush(), done.published) : 0;
  done.published -= missed;
  if (missed > 0 && done.status == PublishStatus::ok) done.status = PublishStatus::dropped;
  dispatch_.count_dropped(missed);
  return done;
}

Result<PublishStatus> PublisherCore::publish_cdr(std::span<const std::byte> bytes, std::int64_t stamp_ns) {
  const Result<detail::Payload> payload = detail::parse_payload(bytes);
  if (!payload) return tl::unexpected(payload.error());
  const Dispatch::Call call(dispatch_);
  const bool is_wanted = call.outlets().is_wanted;
  if (!is_wanted && bytes.size() <= spec_.max_sample_bytes) return dispatch_.withhold();
  const Result<std::uint32_t> size = maker_.converted_bytes(*payload);
  if (!size) return tl::unexpected(size.error());
  if (!is_wanted) return dispatch_.withhold();
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  if (stamp_ns == 0) stamp_ns = realtime_ns();
  const Result<SampleMaker::Made> made = maker_.convert(call.outlets(), *payload, *size, timeout);
  if (!made) return tl::unexpected(made.error());
  Dispatch::Admission admission = dispatch_.admit(made->sample, stamp_ns);
  if (!admission.passes) return dispatch_.withhold();
  if (!made->sample) return dispatch_.miss(std::move(admission), made->body_bytes);
  return dispatch_.send(made->sample, stamp_ns, std::move(admission), timeout);
}

Result<SampleHandle> PublisherCore::loan(const void* prototype,
                                         std::span<const detail::Reservation> reservations,
                                         detail::ReservedMemory memory) {
  const Dispatch::Call call(dispatch_);
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  return maker_.loan(call.outlets(), prototype, reservations, memory, timeout);
}

PublishStatus PublisherCore::commit(SampleHandle sample, bool has_gaps) {
  const Dispatch::Call call(dispatch_);
  if (has_gaps) {
    if (const PublishStatus status = maker_.close_gaps(*sample); status != PublishStatus::ok) return status;
  }
  const std::int64_t stamp_ns = realtime_ns();
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  Dispatch::Admission admission = dispatch_.admit(sample, stamp_ns);
  if (!admission.passes) return dispatch_.withhold();
  return dispatch_.send(sample, stamp_ns, std::move(admission), timeout);
}

Result<SampleHandle> PublisherCore::loan_cdr(std::size_t body_bytes) {
  const Dispatch::Call call(dispatch_);
  std::chrono::nanoseconds timeout = spec_.max_blocking;
  return maker_.loan_cdr(call.outlets(), body_bytes, timeout);
}

Result<PublishStatus> PublisherCore::commit_cdr(SampleHandle sample) {
  if (const Result<void> valid = maker_.index(*sample); !valid) return tl::unexpected(valid.error());
  return commit(std::move(sample), false);
}

void PublisherCore::expire_history() {
  if (history_ != nullptr) history_->expire(realtime_ns());
}

void PublisherCore::assert_liveliness() {
  asserted_.fetch_add(1, std::memory_order_relaxed);
  if (spec_.asserted && !assertion_reported_.exchange(true, std::memory_order_relaxed)) spec_.asserted();
}

void PublisherCore::close() {
  events_.clear();
  readers_changed_.clear();
}

OfferMonitor::Signs PublisherCore::signs() const {
  return {dispatch_.published(), asserted_.load(std::memory_order_relaxed)};
}

Progress PublisherCore::progress() const {
  const std::uint64_t dropped = dispatch_.dropped() + late_readers_.missed();
  const std::uint64_t published = dispatch_.published();
  return {id(), published - std::min(published, dropped), spec_.book->total().bytes};
}

bool PublisherCore::keeps_promises(std::uint64_t deadlines_missed, bool alive) {
  const bool is_news = deadlines_missed != deadlines_missed_.load(std::memory_order_relaxed) ||
                       alive != alive_.load(std::memory_order_relaxed);
  deadlines_missed_.store(deadlines_missed, std::memory_order_relaxed);
  alive_.store(alive, std::memory_order_relaxed);
  return is_news;
}

bool PublisherCore::wait_for_readers(std::size_t count, std::chrono::nanoseconds timeout) const {
  const auto deadline = deadline_after(timeout);
  Lock lock(status_mutex_);
  while (served() < count && readers_known_.wait_until(lock, deadline)) continue;
  return served() >= count;
}

std::size_t PublisherCore::served() const {
  const auto count =
      std::ranges::count_if(readers_, [](const PublisherStatus::Reader& r) { return r.served; });
  return static_cast<std::size_t>(count) + (vanilla_ == nullptr ? 0 : vanilla_->readers());
}

PublisherStatus PublisherCore::status() const {
  PublisherStatus status;
  status.id = spec_.id;
  status.deadlines_missed = deadlines_missed_.load(std::memory_order_relaxed);
  status.alive = alive_.load(std::memory_order_relaxed);
  status.published = dispatch_.published();
  status.dropped = dispatch_.dropped() + late_readers_.missed();
  status.diverted = diverted();
  if (network_ != nullptr) {
    const NetworkWriter::Counters sent = network_->counters();
    status.bytes_sent = sent.bytes_sent;
    status.dropped += sent.dropped;
  }
  status.bytes_saved = spec_.book->total().bytes_saved;
  const Lock lock(status_mutex_);
  status.mask = encoded_;
  status.vanilla_readers = vanilla_ == nullptr ? 0 : vanilla_->readers();
  status.readers = readers_;
  for (PublisherStatus::Reader& reader : status.readers) {
    const Delivered delivered = spec_.book->of(reader.id);
    reader.published = delivered.sent + delivered.withheld + delivered.dropped;
    reader.sent = delivered.sent;
    reader.withheld = delivered.withheld;
    reader.dropped = delivered.dropped;
    reader.retained = delivered.retained;
    reader.diverted = delivered.diverted;
    reader.bytes_sent = delivered.bytes;
    reader.bytes_saved = delivered.bytes_saved;
    if (network_ != nullptr && reader.served && reader.transport == TransportKind::udp) {
      reader.multicast = network_->multicast(reader.id);
      if (const std::string trouble = network_->path_trouble(reader.id); !trouble.empty())
        reader.reason += (reader.reason.empty() ? "" : "; ") + trouble;
    }
  }
  return status;
}

}  // namespace sft::core
