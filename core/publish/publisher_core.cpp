#include "core/publish/publisher_core.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <new>
#include <thread>

#include "core/platform/clock.h"
#include "sft/detail/convert.h"
#include "sft/detail/encode.h"
#include "sft/detail/encode_fault.h"

namespace sft::core {

namespace {

/// A sample that is not encoded whole is measured, for what it saves, only so often: to walk through a large
/// message can take longer than to encode a few of its fields.
constexpr std::int64_t measured_every_ns = 10'000'000;

/// Of a span, with the same outlets: whoever changes these waits no longer.
constexpr std::size_t span_at_once = 1024;

/// Memory that a publisher keeps for its next sample.
constexpr std::size_t spare_bytes_max = 4096;

bool equal_but_for_number(ReaderStatus a, const ReaderStatus& b) {
  a.request_sequence = b.request_sequence;
  return a == b;
}

}  // namespace

PublisherCore::PublisherCore(Spec spec, std::shared_ptr<BufferPool> heap, std::shared_ptr<WriterPort> udp)
    : spec_(std::move(spec)),
      full_(spec_.type->full()),
      onto_itself_(spec_.type->type(), full_),
      layout_(spec_.type->slots()),
      heap_(std::move(heap)),
      udp_(std::move(udp)),
      history_(spec_.qos.durability == Durability::volatile_
                   ? nullptr
                   : std::make_unique<History>(spec_.qos.history_depth, spec_.qos.lifespan.count())),
      events_(spec_.on_event),
      readers_changed_(spec_.on_readers_changed),
      encoded_(spec_.type->none()) {
  if (udp_ != nullptr) udp_->count_in(book_);
  outlets_.store(outlets_for({}, nullptr));
}

std::shared_ptr<Outlets> PublisherCore::outlets_for(const Serving& serving,
                                                    std::shared_ptr<WriterPort> shm) const {
  return make_outlets(type(), serving, gates_, {std::move(shm), udp_ != nullptr, retains()});
}

void PublisherCore::turn_to(const Outlets& outlets) noexcept {
  book_->turn_to(DeliveryBook::Teller::publisher, outlets.page);
  if (udp_ != nullptr && !outlets.to_udp) udp_->rest();
  counted_ = &outlets;
}

/// Routes of readers that are to be given the history now, and not already at that address.
std::vector<Route> PublisherCore::take_latecomers(const Serving& serving) {
  std::vector<Route> latecomers;
  std::map<EndpointId, Locator> begun;
  for (const Route& route : serving.udp) {
    if (route.history == 0) continue;
    begun.emplace(route.reader, route.destination);
    const auto before = history_begun_.find(route.reader);
    if (before == history_begun_.end() || before->second != route.destination) latecomers.push_back(route);
  }
  history_begun_ = std::move(begun);
  return latecomers;
}

/// Whether a reader that was served by UDP is served in shared memory from now on.
bool PublisherCore::changes_over(const Serving& serving) {
  const bool somebody_does =
      std::ranges::any_of(serving.shm, [this](const Route& route) { return by_udp_.contains(route.reader); });
  by_udp_.clear();
  for (const Route& route : serving.udp) by_udp_.insert(route.reader);
  return somebody_does;
}

/// What a latecomer gets of the history, and what of the samples published meanwhile: these wait from
/// set_routes() on, and whatever send() sends by earlier routes or outlets, which do not reach it, is in the
/// history by the time that it is looked at. Both may hold one sample; the reader takes it once.
void PublisherCore::serve(Serving serving, std::shared_ptr<WriterPort> shm) {
  gates_.tidy();
  for (auto* routes : {&serving.shm, &serving.udp, &serving.spare}) gates_.give(*routes);
  const std::vector<Route> latecomers = take_latecomers(serving);
  const std::shared_ptr<Outlets> after = outlets_for(serving, std::move(shm));
  const std::shared_ptr<const Outlets> before = outlets_.share();
  if (!before->provides_for(*after)) {
    // A route must never ask for more than is encoded, or by a gate that was not asked: first do what old and
    // new routes need together, wait for a call that may have begun before that, and only then change the
    // routes.
    outlets_.store(std::make_shared<Outlets>(before->with(*after)));
    calls_.wait_for_present_call();
  }
  book_->enter(after->page);
  if (after->shm != nullptr) after->shm->set_routes(serving.shm);
  if (changes_over(serving)) {
    // It must not fall between two ports: for a moment it is sent samples by both, and takes them once.
    auto both = std::make_shared<Outlets>(before->with(*after));
    both->shm = after->shm;
    both->to_shm = true;
    outlets_.store(std::move(both));
    calls_.wait_for_present_call();
  }
  if (udp_ != nullptr) {
    std::vector<Route> routes = serving.udp;
    if (after->has_spares) routes.insert(routes.end(), serving.spare.begin(), serving.spare.end());
    udp_->set_routes(std::move(routes));
  }
  outlets_.store(after);
  give_history(serving, latecomers);
  std::set<EndpointId> known;
  for (const ReaderStatus& reader : serving.readers) known.insert(reader.id);
  book_->keep(known);
  {
    const std::scoped_lock lock(status_mutex_);
    readers_ = serving.readers;
    encoded_ = after->is_wanted ? after->mask : spec_.type->none();
  }
  readers_known_.notify_all();
  if (readers_changed_.wanted()) readers_changed_.tell(status());
}

void PublisherCore::give_history(const Serving& serving, const std::vector<Route>& latecomers) {
  for (const Route& route : latecomers) {
    std::vector<SampleHandle> samples = history_->last(route.history, realtime_ns());
    book_->retained(route.reader, samples.size());
    udp_->send_history(route, std::move(samples));
  }
  late_in_shm_.clear();
  std::ranges::copy_if(serving.shm, std::back_inserter(late_in_shm_),
                       [](const Route& route) { return route.history != 0; });
  give_history();
}

void PublisherCore::give_history() {
  if (late_in_shm_.empty()) return;
  const std::shared_ptr<WriterPort> shm = outlets_.share()->shm;
  constexpr int attempts = 20;  // each one lost to a sample that was published meanwhile
  for (const Route& route : late_in_shm_) {
    for (int i = 0; shm != nullptr && i < attempts && !give_history(*shm, route); ++i) continue;
  }
}

/// Whether that is done. Asked first is what was held back: all of that, at least, is in the history then.
bool PublisherCore::give_history(WriterPort& shm, const Route& route) {
  const auto held_back = shm.held_back(route.reader);
  if (!held_back) return true;
  const std::vector<SampleHandle> samples = retained_in(shm, route.history);
  if (!shm.begin_with(route, samples, *held_back)) return false;
  book_->retained(route.reader, samples.size());
  return true;
}

/// What was published before there was shared memory is copied there now. What there is no room for is
/// missing, as any sample would be.
std::vector<SampleHandle> PublisherCore::retained_in(WriterPort& shm, std::uint32_t count) {
  std::vector<SampleHandle> samples = history_->last(count, realtime_ns());
  for (SampleHandle& sample : samples) {
    if (shm.holds(*sample)) continue;
    sample = copy_to_shm(shm, sample);
    sample ? history_->replace(sample) : static_cast<void>(dropped_.fetch_add(1, std::memory_order_relaxed));
  }
  std::erase_if(samples, [](const SampleHandle& sample) { return !sample; });
  return samples;
}

void PublisherCore::show(std::vector<ReaderStatus> readers) {
  bool is_news = false;
  {
    const std::scoped_lock lock(status_mutex_);
    is_news = !std::ranges::equal(readers_, readers, equal_but_for_number);
    readers_ = std::move(readers);
  }
  readers_known_.notify_all();
  if (is_news && readers_changed_.wanted()) readers_changed_.tell(status());
}

PublishStatus PublisherCore::publish(const void* value) {
  const CallCount::Call call(calls_);
  const Outlets& outlets = this->outlets();
  if (!outlets.is_wanted) return withhold();
  patience_ = spec_.max_blocking;
  const std::int64_t stamp_ns = realtime_ns();
  return admit(outlets, stamp_ns) ? encode_and_send(outlets, value, stamp_ns) : withhold();
}

PublishedSpan PublisherCore::publish(const void* values, std::size_t count, std::size_t stride) {
  const auto* value = static_cast<const std::byte*>(values);
  patience_ = spec_.max_blocking;
  PublishedSpan all;
  bool goes_on = false;
  while (count > 0) {
    const std::size_t some = std::min(count, span_at_once);
    const PublishedSpan published = publish_some(value, some, stride, goes_on);
    goes_on = true;
    all.published += published.published;
    if (all.status == PublishStatus::ok) all.status = published.status;
    value += some * stride;
    count -= some;
  }
  return all;
}

/// In one call, as far as whoever changes the outlets can tell.
PublishedSpan PublisherCore::publish_some(const std::byte* values, std::size_t count, std::size_t stride,
                                          bool goes_on) {
  const CallCount::Call call(calls_);
  const Outlets& outlets = this->outlets();
  if (!outlets.is_wanted) {
    sequence_.fetch_add(count, std::memory_order_relaxed);
    return {.published = count};
  }
  const std::int64_t stamp_ns = realtime_ns();
  PublishedSpan done;
  if (udp_ != nullptr) udp_->hold(goes_on);
  for (std::size_t i = 0; i < count; ++i) {
    const PublishStatus status =
        admit(outlets, stamp_ns) ? encode_and_send(outlets, values + i * stride, stamp_ns) : withhold();
    done.published += status == PublishStatus::ok ? 1 : 0;
    if (done.status == PublishStatus::ok) done.status = status;
  }
  const std::size_t missed = udp_ == nullptr ? 0 : std::min(udp_->flush(), done.published);
  done.published -= missed;
  if (missed > 0 && done.status == PublishStatus::ok) done.status = PublishStatus::dropped;
  dropped_.fetch_add(missed, std::memory_order_relaxed);
  return done;
}

/// Asks each gate once. False if the sample is for nobody. (Of a durable publisher the routes are those in
/// force once the sample is in the history, see serve().)
bool PublisherCore::admit(const Outlets& outlets, std::int64_t stamp_ns) const noexcept {
  if ((outlets.to_udp || outlets.has_spares) && history_ == nullptr) udp_->begin();
  bool passes = outlets.to_all || outlets.gates.empty() || history_ != nullptr;
  for (const auto& gate : outlets.gates) {
    gate->consider(stamp_ns);
    passes |= gate->passes();
  }
  return passes;
}

/// Counts a sample that nobody wants, so that readers can tell.
PublishStatus PublisherCore::withhold() noexcept {
  sequence_.fetch_add(1, std::memory_order_relaxed);
  return PublishStatus::ok;
}

PublishStatus PublisherCore::encode_and_send(const Outlets& outlets, const void* value,
                                             std::int64_t stamp_ns) {
  const StructType& type = spec_.type->type();
  const detail::EncodedSize size = detail::encoded_size(type, value, outlets.mask);
  if (size.status != detail::EncodeStatus::ok || size.bytes > spec_.max_sample_bytes) [[unlikely]]
    return refuse(value, outlets.mask);
  const SampleHandle sample = lend(outlets, size.bytes);
  if (!sample) return no_memory(outlets, size.bytes);
  fill_header(*sample, outlets.mask, size.bytes);
  if (!outlets.whole) sample->whole_bytes = whole_bytes(value, size.bytes, stamp_ns);
  // Readers in shared memory and late ones get this very sample.
  const bool may_postpone =
      outlets.to_udp && !outlets.to_shm && history_ == nullptr && udp_->takes_postponed();
  detail::encode(type, value, outlets.mask, {sample->data + layout_.body_offset, size.bytes},
                 {sample->index(), spec_.type->slots()}, {}, may_postpone ? &postponed_ : nullptr);
  if (postponed_.empty()) return send(outlets, sample, stamp_ns);
  sample->postponed = &postponed_;
  const PublishStatus status = send(outlets, sample, stamp_ns);
  if (sample->postponed != nullptr) sample->postponed = nullptr;  // else others may have it, and look
  postponed_.clear();
  return status;
}

/// Only here, where it failed already, a message is looked at for what is wrong with it.
PublishStatus PublisherCore::refuse(const void* value, const FieldMask& mask) {
  why_invalid_ = fault_of(value, mask).message;
  return PublishStatus::invalid;
}

Error PublisherCore::fault_of(const void* value, const FieldMask& mask,
                              std::span<const detail::Reservation> reservations) const {
  const std::size_t most = spec_.max_sample_bytes;
  std::string text =
      "topic '" + spec_.topic + "': " + detail::encode_fault(*spec_.type, value, mask, most, reservations);
  const detail::EncodedSize size = detail::encoded_size(spec_.type->type(), value, mask, reservations);
  if (size.status != detail::EncodeStatus::ok) return {Errc::invalid_argument, std::move(text)};
  return {Errc::limit_exceeded, text + ": raise PublisherOptions::max_sample_bytes"};
}

/// What the body would have if all fields were encoded, as far as that is measured.
std::uint32_t PublisherCore::whole_bytes(const void* value, std::uint32_t encoded_bytes,
                                         std::int64_t stamp_ns) noexcept {
  if (stamp_ns - measured_at_ns_ >= measured_every_ns || stamp_ns < measured_at_ns_) {
    const detail::EncodedSize size = detail::encoded_size(spec_.type->type(), value, full_);
    if (size.status == detail::EncodeStatus::ok) measured_bytes_ = size.bytes;
    measured_at_ns_ = stamp_ns;
  }
  return std::max(measured_bytes_, encoded_bytes);
}

/// Counts a sample that could not be made, so that readers see that one is missing.
PublishStatus PublisherCore::no_memory(const Outlets& outlets, std::uint32_t body_bytes) noexcept {
  sequence_.fetch_add(1, std::memory_order_relaxed);
  dropped_.fetch_add(1, std::memory_order_relaxed);
  for (const Outlets::Locals& locals : outlets.locals) {
    if (locals.want()) locals.tally->dropped();
  }
  if (outlets.to_udp) udp_->miss();
  if (outlets.to_shm) count_refusal(outlets, body_bytes);
  return PublishStatus::no_memory;
}

/// Of a loan in shared memory.
void PublisherCore::count_refusal(const Outlets& outlets, std::uint32_t body_bytes) noexcept {
  const bool too_large = layout_.bytes(body_bytes) > outlets.shm->largest_loan_bytes();
  (too_large ? too_large_ : exhausted_).fetch_add(1, std::memory_order_relaxed);
}

Result<PublishStatus> PublisherCore::publish_cdr(std::span<const std::byte> bytes) {
  const StructType& type = spec_.type->type();
  const Result<detail::Payload> payload = detail::parse_payload(bytes);
  if (!payload) return tl::unexpected(payload.error());
  const CallCount::Call call(calls_);
  const Outlets& outlets = this->outlets();
  if (!outlets.is_wanted) return withhold();
  detail::ConvertedSize size = detail::converted_size(*payload, type);
  if (size.status != detail::WalkStatus::ok) return malformed(size.status);
  if (size.bytes > spec_.max_sample_bytes) {
    return fail(Errc::limit_exceeded, "topic '" + spec_.topic + "': the payload has " +
                                          std::to_string(size.bytes) + " bytes; at most " +
                                          std::to_string(spec_.max_sample_bytes) +
                                          " may be sent: raise PublisherOptions::max_sample_bytes");
  }
  patience_ = spec_.max_blocking;
  const std::int64_t stamp_ns = realtime_ns();
  const SampleHandle sample = lend(outlets, size.bytes);
  if (!sample) return admit(outlets, stamp_ns) ? no_memory(outlets, size.bytes) : withhold();
  const std::span<std::byte> body(sample->data + layout_.body_offset, size.bytes);
  const detail::SampleState state{.body = body.data(), .body_bytes = size.bytes, .mask = &full_};
  detail::WalkStatus status = detail::convert(*payload, type, body);
  if (status == detail::WalkStatus::ok)
    status = detail::build_index(state, type, {sample->index(), spec_.type->slots()}, &size.bytes);
  if (status != detail::WalkStatus::ok) return malformed(status);
  fill_header(*sample, full_, size.bytes);
  return admit(outlets, stamp_ns) ? send(outlets, sample, stamp_ns) : withhold();
}

tl::unexpected<Error> PublisherCore::malformed(detail::WalkStatus why) const {
  return fail(Errc::malformed, "not a " + std::string(spec_.type->name()) + ": " + to_string(why));
}

Result<SampleHandle> PublisherCore::loan(const void* prototype,
                                         std::span<const detail::Reservation> reservations,
                                         detail::ReservedMemory memory) {
  const detail::EncodedSize size = detail::encoded_size(spec_.type->type(), prototype, full_, reservations);
  if (size.status != detail::EncodeStatus::ok || size.bytes > spec_.max_sample_bytes)
    return tl::unexpected(fault_of(prototype, full_, reservations));
  const CallCount::Call call(calls_);
  patience_ = spec_.max_blocking;
  SampleHandle sample = lend(outlets(), size.bytes);
  if (!sample) return fail(Errc::out_of_memory, "no memory free for a loan: readers or loans hold too much");
  fill_header(*sample, full_, size.bytes);
  const std::span body(sample->data + layout_.body_offset, size.bytes);
  const auto is_reserved = [](const detail::Reservation& r) { return r.length.has_value(); };
  if (memory == detail::ReservedMemory::zeroed && std::ranges::any_of(reservations, is_reserved))
    std::memset(body.data(), 0, body.size());
  detail::encode(spec_.type->type(), prototype, full_, body, {sample->index(), spec_.type->slots()},
                 reservations);
  return sample;
}

PublishStatus PublisherCore::commit(SampleHandle sample, bool has_gaps) {
  if (has_gaps) {
    if (const PublishStatus status = close_gaps(*sample); status != PublishStatus::ok) {
      if (status == PublishStatus::invalid)
        why_invalid_ =
            "topic '" + spec_.topic + "': another program has overwritten the loan in shared memory";
      return status;
    }
  }
  const std::int64_t stamp_ns = realtime_ns();
  const CallCount::Call call(calls_);
  const Outlets& outlets = this->outlets();
  patience_ = spec_.max_blocking;
  return admit(outlets, stamp_ns) ? send(outlets, sample, stamp_ns) : withhold();
}

/// The body becomes what encoding the shorter sequences would have made. Nothing of it lies further behind
/// then than before, so that it can be moved front to back within the same memory; what a segment is copied
/// over was moved already.
PublishStatus PublisherCore::close_gaps(SampleBuffer& sample) noexcept try {
  detail::SampleHeader& header = sample.header();
  std::byte* const body = sample.data + layout_.body_offset;
  detail::SampleState state = state_of(sample, spec_.type->slots());
  // In shared memory a broken program may have changed lengths and index meanwhile.
  if (!closing_.project(state, onto_itself_) || closing_.bytes() > state.body_bytes)
    return PublishStatus::invalid;
  std::byte* to = body;
  for (const detail::Segment& segment : closing_.segments()) {
    if (to != segment.data) std::memmove(to, segment.data, segment.bytes);
    to += segment.bytes;
  }
  state.body_bytes = header.body_bytes = sample.whole_bytes = static_cast<std::uint32_t>(closing_.bytes());
  const detail::WalkStatus walked =
      detail::build_index(state, spec_.type->type(), {sample.index(), spec_.type->slots()});
  return walked == detail::WalkStatus::ok ? PublishStatus::ok : PublishStatus::invalid;
} catch (const std::bad_alloc&) {
  return PublishStatus::no_memory;
}

SampleHandle PublisherCore::lend(const Outlets& outlets, std::uint32_t body_bytes) noexcept {
  const std::size_t bytes = layout_.bytes(body_bytes);
  SampleHandle sample;
  if (outlets.to_shm) sample = outlets.shm->loan(bytes);
  if (!sample && outlets.needs_shm && patience_.count() > 0) sample = await_chunk(outlets, bytes);
  // Without a chunk it can still go by UDP.
  if (!sample && (!outlets.to_shm || outlets.to_udp || outlets.has_spares)) sample = take_heap(bytes);
  return sample;
}

/// Until a reader gives one back, as long as patience lasts.
SampleHandle PublisherCore::await_chunk(const Outlets& outlets, std::size_t bytes) noexcept {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds pause{1};
  if (bytes > outlets.shm->largest_loan_bytes()) return {};
  SampleHandle sample;
  const Clock::time_point until = Clock::now() + patience_;
  while (!sample && Clock::now() < until) {
    std::this_thread::sleep_for(std::min<Clock::duration>(pause, until - Clock::now()));
    sample = outlets.shm->loan(bytes);
  }
  patience_ = std::max<std::chrono::nanoseconds>(until - Clock::now(), {});
  return sample;
}

/// The memory of the last sample, where nobody has kept that and it is not too large.
SampleHandle PublisherCore::take_heap(std::size_t bytes) noexcept {
  if (bytes > spare_bytes_max) return heap_->take(bytes);
  if (!spare_ || !spare_.is_only() || spare_->capacity < bytes) spare_ = heap_->take(bytes);
  return spare_;
}

void PublisherCore::fill_header(SampleBuffer& buffer, const FieldMask& mask,
                                std::uint32_t body_bytes) noexcept {
  detail::SampleHeader& header = buffer.header();
  header = detail::SampleHeader{};
  header.slots = static_cast<std::uint32_t>(spec_.type->slots());
  header.writer = spec_.id;
  header.type_hash = spec_.type->hash();
  header.body_offset = static_cast<std::uint32_t>(layout_.body_offset);
  header.body_bytes = body_bytes;
  buffer.mask = mask;
  buffer.whole_bytes = body_bytes;
  // Between index and encapsulation nothing may remain of what the memory held before.
  std::byte* const encapsulation = buffer.data + layout_.body_offset - detail::encapsulation_bytes;
  auto* const index_end = reinterpret_cast<std::byte*>(buffer.index() + spec_.type->slots());
  std::fill(index_end, encapsulation, std::byte{0});
  std::memcpy(encapsulation, detail::encapsulation_cdr_le.data(), detail::encapsulation_bytes);
}

/// `before`: what was in force when the sample was made.
PublishStatus PublisherCore::send(const Outlets& before, const SampleHandle& sample,
                                  std::int64_t stamp_ns) noexcept {
  detail::SampleHeader& header = sample->header();
  header.sequence = sequence_.fetch_add(1, std::memory_order_relaxed) + 1;
  header.source_stamp_ns = stamp_ns;
  header.diverted_sequence = diverted_sequence_;
  header.diverted_stamp_ns = diverted_stamp_ns_;
  sample->trust_header();
  if (history_ != nullptr) history_->add(sample);
  const Outlets& outlets = history_ == nullptr ? before : this->outlets();  // see serve()
  PublishStatus status = PublishStatus::ok;
  bool diverted = false;
  if (outlets.to_shm) {
    const SendStatus in_shm = send_to_shm(outlets, sample);
    if (in_shm == SendStatus::displaced) status = PublishStatus::dropped;
    if (in_shm == SendStatus::sent || in_shm == SendStatus::displaced) {
      for (const Outlets::Locals& locals : outlets.locals) {
        if (locals.want()) locals.tally->sent(0, 0);
      }
    } else {
      status = divert(outlets, sample);
      diverted = outlets.has_spares;
    }
  }
  if (outlets.to_udp && !outlets.to_shm) note_sent_by_udp_alone(*sample);
  if (outlets.to_udp || diverted) {
    if (spec_.max_blocking.count() > 0) udp_->be_patient(patience_);
    if (udp_->send(sample) != SendStatus::sent) status = PublishStatus::dropped;
  }
  if (status != PublishStatus::ok) dropped_.fetch_add(1, std::memory_order_relaxed);
  return status;
}

/// It may have been lent elsewhere, before shared memory came up or while it had no chunk free.
SendStatus PublisherCore::send_to_shm(const Outlets& outlets, const SampleHandle& sample) noexcept {
  const SampleHandle local = outlets.shm->can_send(*sample) ? sample : copy_to_shm(*outlets.shm, sample);
  if (local) {
    if (spec_.max_blocking.count() > 0) outlets.shm->be_patient(patience_);
    const SendStatus status = outlets.shm->send(local);
    if (spec_.max_blocking.count() > 0) patience_ = outlets.shm->patience_left();
    if (status != SendStatus::sent && status != SendStatus::displaced)
      unavailable_.fetch_add(1, std::memory_order_relaxed);
    return status;
  }
  count_refusal(outlets, sample->header().body_bytes);
  return SendStatus::dropped;
}

/// Later ones in shared memory tell their readers that they may have to wait for it: it is under way for
/// longer.
void PublisherCore::note_sent_by_udp_alone(const SampleBuffer& sample) noexcept {
  diverted_sequence_ = sample.sequence;
  diverted_stamp_ns_ = sample.source_stamp_ns;
}

/// Shared memory does not take it: it goes by UDP to whom it can.
PublishStatus PublisherCore::divert(const Outlets& outlets, const SampleHandle& sample) noexcept {
  if (outlets.has_spares) {
    udp_->include_spares();
    note_sent_by_udp_alone(*sample);
  }
  PublishStatus status = PublishStatus::ok;
  for (const Outlets::Locals& locals : outlets.locals) {
    if (locals.spare || !locals.want()) continue;
    locals.tally->dropped();
    status = PublishStatus::dropped;
  }
  return status;
}

SampleHandle PublisherCore::copy_to_shm(WriterPort& shm, const SampleHandle& sample) const noexcept {
  if (!sample->mask.is_full()) return {};
  // It may lie in shared memory too: of a port that is gone.
  const std::size_t bytes = layout_.bytes(state_of(*sample, spec_.type->slots()).body_bytes);
  SampleHandle copy = shm.loan(bytes);
  if (!copy) return {};
  std::memcpy(copy->data, sample->data, bytes);
  copy->mask = sample->mask;
  copy->whole_bytes = sample->whole_bytes;
  copy->trust_header();
  return copy;
}

void PublisherCore::expire_history() {
  if (history_ != nullptr) history_->expire(realtime_ns());
}

void PublisherCore::assert_liveliness() {
  asserted_.fetch_add(1, std::memory_order_relaxed);
  if (spec_.asserted && !assertion_told_.exchange(true, std::memory_order_relaxed)) spec_.asserted();
}

void PublisherCore::close() {
  events_.close();
  readers_changed_.close();
}

OfferWatch::Signs PublisherCore::signs() const {
  return {sequence_.load(std::memory_order_relaxed), asserted_.load(std::memory_order_relaxed)};
}

Progress PublisherCore::progress() const {
  const std::uint64_t dropped = dropped_.load(std::memory_order_relaxed);
  const std::uint64_t published = sequence_.load(std::memory_order_relaxed);
  return {id(), published - std::min(published, dropped), book_->total().bytes};
}

bool PublisherCore::keeps_promises(std::uint64_t deadlines_missed, bool alive) {
  const bool is_news = deadlines_missed != deadlines_missed_.load(std::memory_order_relaxed) ||
                       alive != alive_.load(std::memory_order_relaxed);
  deadlines_missed_.store(deadlines_missed, std::memory_order_relaxed);
  alive_.store(alive, std::memory_order_relaxed);
  return is_news;
}

Diverted PublisherCore::diverted() const {
  return {exhausted_.load(std::memory_order_relaxed), too_large_.load(std::memory_order_relaxed),
          unavailable_.load(std::memory_order_relaxed)};
}

bool PublisherCore::wait_for_readers(std::size_t count, std::chrono::nanoseconds timeout) const {
  const auto are_served = [&] {
    const auto served = std::ranges::count_if(readers_, [](const ReaderStatus& r) { return r.served; });
    return static_cast<std::size_t>(served) >= count;
  };
  std::unique_lock lock(status_mutex_);
  return readers_known_.wait_until(lock, deadline_after(timeout), are_served);
}

PublisherStatus PublisherCore::status() const {
  PublisherStatus status;
  status.deadlines_missed = deadlines_missed_.load(std::memory_order_relaxed);
  status.alive = alive_.load(std::memory_order_relaxed);
  status.published = sequence_.load(std::memory_order_relaxed);
  status.dropped = dropped_.load(std::memory_order_relaxed);
  status.diverted = diverted();
  if (udp_ != nullptr) {
    status.bytes_sent = udp_->bytes_sent();
    status.dropped += udp_->dropped();
  }
  status.bytes_saved = book_->total().bytes_saved;
  const std::scoped_lock lock(status_mutex_);
  status.mask = encoded_;
  status.readers = readers_;
  for (ReaderStatus& reader : status.readers) {
    const Delivered delivered = book_->of(reader.id);
    reader.published = delivered.sent + delivered.withheld + delivered.dropped;
    reader.sent = delivered.sent;
    reader.withheld = delivered.withheld;
    reader.dropped = delivered.dropped;
    reader.retained = delivered.retained;
    reader.diverted = delivered.diverted;
    reader.bytes_sent = delivered.bytes;
    reader.bytes_saved = delivered.bytes_saved;
    if (udp_ != nullptr && reader.served && reader.transport == TransportKind::udp) {
      reader.multicast = udp_->multicast(reader.id);
      if (const std::string silence = udp_->silence(reader.id); !silence.empty())
        reader.reason += (reader.reason.empty() ? "" : "; ") + silence;
    }
  }
  return status;
}

}  // namespace sft::core
