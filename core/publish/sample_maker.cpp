#include "core/publish/sample_maker.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <thread>
#include <utility>

#include "core/seam/gate_table.h"
#include "sft/detail/encode.h"
#include "sft/detail/encode_fault.h"
#include "sft/options.h"

namespace sft::core {

namespace {

/// The minimum time between two reported refusals.
constexpr std::chrono::seconds refusals_pause{1};

/// Returns a hint for a message that is too large: the option that limits the size, unless that option
/// already has the largest possible value, which is the default.
std::string what_to_do_about(std::size_t max_sample_bytes) {
  return max_sample_bytes < PublisherOptions().max_sample_bytes
             ? ": raise PublisherOptions::max_sample_bytes"
             : ", which no option raises: divide it into several samples";
}

tl::unexpected<Error> no_loan() {
  return fail(Errc::out_of_memory, "no memory free for a loan: readers or loans hold too much");
}

/// Waits for at most `timeout` until readers have released memory. The handle is empty if they have not.
SampleHandle await_chunk(LendingWriter& memory, std::size_t bytes, std::chrono::nanoseconds& timeout) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds pause{1};
  if (bytes > memory.largest_loan_bytes()) return {};
  SampleHandle sample;
  const Clock::time_point until = Clock::now() + timeout;
  while (!sample && Clock::now() < until) {
    std::this_thread::sleep_for(std::min<Clock::duration>(pause, until - Clock::now()));
    sample = memory.loan(bytes);
  }
  timeout = std::max<std::chrono::nanoseconds>(until - Clock::now(), {});
  return sample;
}

}  // namespace

SampleMaker::SampleMaker(Product product, std::shared_ptr<BufferPool> heap)
    : product_(std::move(product)),
      type_(*product_.type),
      full_(type_.full()),
      layout_(type_.index_slots()),
      heap_(std::move(heap)),
      onto_itself_(type_.type(), full_) {}

bool SampleMaker::is_sendable(const detail::Message& message) {
  const detail::EncodedSize size = detail::encoded_size(message.type, message.value, full_);
  if (size.status != detail::EncodeStatus::ok || size.bytes > product_.max_sample_bytes) [[unlikely]] {
    refuse(message, full_);
    return false;
  }
  whole_bytes_ = size.bytes;
  return true;
}

SampleMaker::Made SampleMaker::encode(const Outlets& outlets, const detail::Message& message,
                                      bool may_postpone, std::chrono::nanoseconds& timeout) {
  const detail::EncodedSize size = detail::encoded_size(message.type, message.value, outlets.mask);
  if (size.status != detail::EncodeStatus::ok || size.bytes > product_.max_sample_bytes) [[unlikely]]
    return {{}, refuse(message, outlets.mask), 0};
  Made made{lend(outlets, size.bytes, timeout), PublishStatus::ok, size.bytes};
  if (!made.sample) {
    made.why_not = PublishStatus::no_memory;
    return made;
  }
  SampleBuffer& sample = *made.sample;
  fill_header(sample, outlets.mask, size.bytes);
  if (!outlets.whole) sample.whole_bytes = whole_bytes_;
  sft::detail::encode(message.type, message.value, outlets.mask,
                      {sample.data + layout_.body_offset, size.bytes}, {sample.index(), type_.index_slots()},
                      {}, may_postpone ? &postponed_ : nullptr);
  if (!postponed_.empty()) sample.postponed = &postponed_;
  return made;
}

/// Determines the reason why the message is invalid, and reports it. Called only after encoding has failed.
PublishStatus SampleMaker::refuse(const detail::Message& message, const FieldMask& mask) {
  why_invalid_ = fault_of(message, mask).message;
  if (const Time now = std::chrono::steady_clock::now(); now >= next_refusal_logged_) {
    next_refusal_logged_ = now + refusals_pause;
    product_.refused(why_invalid_);
  }
  return PublishStatus::invalid;
}

Error SampleMaker::fault_of(const detail::Message& message, const FieldMask& mask,
                            std::span<const detail::Reservation> reservations) const {
  const std::size_t most = product_.max_sample_bytes;
  std::string text =
      "topic '" + product_.topic + "': " + detail::encode_fault(type_, message, mask, most, reservations);
  const detail::EncodedSize size = detail::encoded_size(message.type, message.value, mask, reservations);
  if (size.status != detail::EncodeStatus::ok) return {Errc::invalid_argument, std::move(text)};
  return {Errc::limit_exceeded, text + what_to_do_about(most)};
}

Result<std::uint32_t> SampleMaker::converted_bytes(const detail::Payload& payload) const {
  const detail::ConvertedSize size = detail::converted_size(payload, type_.type());
  if (size.status != detail::WalkStatus::ok) return malformed(size.status);
  return check_size(size.bytes).map([&] { return size.bytes; });
}

Result<void> SampleMaker::check_size(std::size_t body_bytes) const {
  if (body_bytes <= product_.max_sample_bytes) return {};
  return fail(Errc::limit_exceeded, "topic '" + product_.topic + "': the payload has " +
                                        std::to_string(body_bytes) + " bytes; at most " +
                                        std::to_string(product_.max_sample_bytes) + " may be sent" +
                                        what_to_do_about(product_.max_sample_bytes));
}

Result<SampleMaker::Made> SampleMaker::convert(const Outlets& outlets, const detail::Payload& payload,
                                               std::uint32_t body_bytes, std::chrono::nanoseconds& timeout) {
  SampleHandle sample = lend(outlets, body_bytes, timeout);
  if (!sample) return Made{{}, PublishStatus::no_memory, body_bytes};
  const std::span<std::byte> body(sample->data + layout_.body_offset, body_bytes);
  const detail::SampleState state{.body = body.data(), .body_bytes = body_bytes, .mask = &full_};
  detail::WalkStatus status = sft::detail::convert(payload, type_.type(), body);
  if (status == detail::WalkStatus::ok)
    status = detail::build_index(state, type_.type(), {sample->index(), type_.index_slots()}, &body_bytes);
  if (status != detail::WalkStatus::ok) return malformed(status);
  fill_header(*sample, full_, body_bytes);
  return Made{std::move(sample), PublishStatus::ok, body_bytes};
}

tl::unexpected<Error> SampleMaker::malformed(detail::WalkStatus why) const {
  return fail(Errc::malformed, "not a " + std::string(type_.name()) + ": " + to_string(why));
}

Result<SampleHandle> SampleMaker::loan(const Outlets& outlets, const void* prototype,
                                       std::span<const detail::Reservation> reservations,
                                       detail::ReservedMemory memory, std::chrono::nanoseconds& timeout) {
  const detail::EncodedSize size = detail::encoded_size(type_.type(), prototype, full_, reservations);
  if (size.status != detail::EncodeStatus::ok || size.bytes > product_.max_sample_bytes)
    return tl::unexpected(fault_of({type_.type(), prototype}, full_, reservations));
  SampleHandle sample = lend(outlets, size.bytes, timeout);
  if (!sample) return no_loan();
  fill_header(*sample, full_, size.bytes);
  const std::span body(sample->data + layout_.body_offset, size.bytes);
  const auto is_reserved = [](const detail::Reservation& r) { return r.length.has_value(); };
  if (memory == detail::ReservedMemory::zeroed && std::ranges::any_of(reservations, is_reserved))
    std::memset(body.data(), 0, body.size());
  sft::detail::encode(type_.type(), prototype, full_, body, {sample->index(), type_.index_slots()},
                      reservations);
  return sample;
}

Result<SampleHandle> SampleMaker::loan_cdr(const Outlets& outlets, std::size_t body_bytes,
                                           std::chrono::nanoseconds& timeout) {
  if (const Result<void> fits = check_size(body_bytes); !fits) return tl::unexpected(fits.error());
  const auto bytes = static_cast<std::uint32_t>(body_bytes);
  SampleHandle sample = lend(outlets, bytes, timeout);
  if (!sample) return no_loan();
  fill_header(*sample, full_, bytes);
  return sample;
}

Result<void> SampleMaker::index(SampleBuffer& sample) const {
  std::uint32_t bytes = sample.header().body_bytes;
  const detail::SampleState state{
      .body = sample.data + layout_.body_offset, .body_bytes = bytes, .mask = &full_};
  const detail::WalkStatus status =
      detail::build_index(state, type_.type(), {sample.index(), type_.index_slots()}, &bytes);
  if (status != detail::WalkStatus::ok) return malformed(status);
  sample.header().body_bytes = sample.whole_bytes = bytes;
  return {};
}

PublishStatus SampleMaker::close_gaps(SampleBuffer& sample) noexcept try {
  const PublishStatus status = move_together(sample);
  if (status == PublishStatus::invalid) {
    why_invalid_ =
        "topic '" + product_.topic + "': another program has overwritten the loan in shared memory";
  }
  return status;
} catch (const std::bad_alloc&) {
  return PublishStatus::no_memory;
}

/// Closes the gaps of a loan within its memory. All bytes move towards the beginning of the body. So the
/// segments are moved in ascending order, and each segment overwrites only bytes that were moved already.
PublishStatus SampleMaker::move_together(SampleBuffer& sample) {
  std::byte* const body = sample.data + layout_.body_offset;
  detail::SampleState state = state_of(sample, type_.index_slots());
  // Meanwhile a broken program may have changed lengths and the index in shared memory.
  if (!closing_.project(state, onto_itself_) || closing_.bytes() > state.body_bytes)
    return PublishStatus::invalid;
  std::byte* to = body;
  for (const detail::Segment& segment : closing_.segments()) {
    if (to != segment.data) std::memmove(to, segment.data, segment.bytes);
    to += segment.bytes;
  }
  const auto bytes = static_cast<std::uint32_t>(closing_.bytes());
  state.body_bytes = sample.header().body_bytes = sample.whole_bytes = bytes;
  const detail::WalkStatus walked =
      detail::build_index(state, type_.type(), {sample.index(), type_.index_slots()});
  return walked == detail::WalkStatus::ok ? PublishStatus::ok : PublishStatus::invalid;
}

SampleHandle SampleMaker::lend(const Outlets& outlets, std::uint32_t body_bytes,
                               std::chrono::nanoseconds& timeout) noexcept {
  const std::size_t bytes = layout_.bytes(body_bytes);
  const std::size_t with_gates = bytes + gate_table_bytes(outlets.memory_gates.size());
  SampleHandle sample;
  if (outlets.to_memory) sample = outlets.memory->loan(with_gates);
  if (!sample && with_gates != bytes) sample = outlets.memory->loan(bytes);  // without a gate table
  if (!sample && outlets.needs_memory && timeout.count() > 0)
    sample = await_chunk(*outlets.memory, bytes, timeout);
  // If no chunk is free, the sample can still be sent by other paths, from heap memory.
  const bool may_go_elsewhere = outlets.to_network || outlets.has_fallback || outlets.vanilla != nullptr;
  if (!sample && (!outlets.to_memory || may_go_elsewhere)) sample = take_heap(bytes);
  return sample;
}

void SampleMaker::fill_header(SampleBuffer& buffer, const FieldMask& mask,
                              std::uint32_t body_bytes) const noexcept {
  detail::SampleHeader& header = buffer.header();
  header = detail::SampleHeader{};
  header.index_slots = static_cast<std::uint16_t>(type_.index_slots());
  header.writer = product_.writer;
  header.type_hash = type_.hash();
  header.body_offset = static_cast<std::uint32_t>(layout_.body_offset);
  header.body_bytes = body_bytes;
  buffer.mask = mask;
  buffer.whole_bytes = body_bytes;
  // Clears the bytes between index and encapsulation, so that no earlier contents of the memory remain there.
  std::byte* const encapsulation = buffer.data + layout_.body_offset - detail::encapsulation_bytes;
  auto* const index_end = reinterpret_cast<std::byte*>(buffer.index() + type_.index_slots());
  std::fill(index_end, encapsulation, std::byte{0});
  std::memcpy(encapsulation, detail::encapsulation_cdr_le.data(), detail::encapsulation_bytes);
}

}  // namespace sft::core
