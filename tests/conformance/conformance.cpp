#include "tests/conformance/conformance.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace sft::conformance {

using namespace detail;
using core::SampleHandle;
using core::SendStatus;

namespace {
using Clock = std::chrono::steady_clock;

/// Returns the part of the image that the selection names. Computes it index by index.
Image part_of(Image image, const Selection& wanted) {
  const std::size_t leaf = *fields<Image>("data").begin();
  const Selection::Part* const part = wanted.part(leaf);
  if (part == nullptr) return image;
  std::vector<std::uint8_t> kept;
  const std::size_t end = std::min<std::size_t>(part->columns.end, image.data.size());
  for (std::size_t i = part->columns.begin; i < end; i += part->columns.step) kept.push_back(image.data[i]);
  image.data = std::move(kept);
  return image;
}

AnyReader open_reader(const AnyTransport& node, const core::ReaderSpec& spec) {
  if (node.memory() != nullptr) return node.memory()->open_reader(spec).value();
  return node.network()->open_reader(spec).value();
}

AnyWriter open_writer(const AnyTransport& node, const core::WriterSpec& spec) {
  if (node.memory() != nullptr) return node.memory()->open_writer(spec).value();
  return node.network()->open_writer(spec).value();
}
}  // namespace

Reader::Reader(Stage& stage, const ReaderOptions& options)
    : bell_(stage.bells->at(stage.readers)),
      type_(*options.type),
      reliable_(stage.medium->traits().reliable && !options.best_effort) {
  const core::DoorbellAddress bell{stage.bells->id(), stage.readers++};
  const core::EndpointId id = 1000 + stage.readers;
  core::ReaderSpec spec{.id = id, .type = &type_, .depth = options.depth, .doorbell = bell};
  spec.listener = this;
  spec.only_waited_for = true;
  port_ = open_reader(stage.here, spec);
  std::vector<core::Accepted> accepted;
  for (const std::string& text : options.masks) accepted.push_back({.wanted = {selection(text, type_)}});
  route_ = {.reader = id,
            .destination = stage.medium->locator(stage.here, bell),
            .selection = accepted[0].wanted.selection};
  route_.reliable = reliable_;
  accept(std::move(accepted));
}

void Reader::accept(std::vector<core::Accepted> accepted) {
  if (port_.network() != nullptr) port_.network()->accept(std::move(accepted));
}

void Reader::hear(const Writer& writer) {
  const Result<void> asked = port_->connect(source(writer));
  ASSERT_TRUE(asked) << asked.error().message;
  ASSERT_TRUE(eventually([&] { return port_->connected(writer.id()); }, hang_timeout));
}

core::Source Reader::source(const Writer& writer) const {
  return {.writer = writer.id(), .reliable = reliable_, .waits = writer.waits()};
}

core::Route Reader::route(const std::string& mask) const { return route(selection(mask, type_)); }

core::Route Reader::route(const Selection& asked) const {
  core::Route route = route_;
  route.selection = asked;
  return route;
}

SampleHandle Reader::take() {
  SampleHandle sample = port_->take();
  if (port_.memory() != nullptr) port_.memory()->notify_room();
  return sample;
}

SampleHandle Reader::next() {
  SampleHandle sample;
  const auto came = [&] { return sample || (sample = take()); };
  for (const auto deadline = Clock::now() + hang_timeout; Clock::now() < deadline;) {
    const std::uint32_t seen = bell_.rings;
    if (came()) break;
    const bool received = port_.network() != nullptr && port_.network()->receive({bell_, seen, deadline, {}});
    if (!received) bell_.wait(deadline, came);
  }
  return sample;
}

std::vector<std::uint64_t> Reader::next_sequences(std::size_t count) {
  std::vector<std::uint64_t> sequences;
  while (sequences.size() < count) {
    const SampleHandle sample = next();
    if (!sample) break;
    sequences.push_back(sequence_of(sample));
  }
  return sequences;
}

std::vector<std::uint64_t> Reader::take_sequences() {
  std::vector<std::uint64_t> sequences;
  while (const SampleHandle sample = take()) sequences.push_back(sequence_of(sample));
  return sequences;
}

Writer::Writer(Stage& stage, core::EndpointId id, std::chrono::nanoseconds max_blocking,
               const TypeSupport& type)
    : id_(id),
      waits_(max_blocking.count() > 0),
      port_(open_writer(stage.there, {id, &type, true, max_blocking})) {}

void Writer::serve(Reader& reader) {
  reader.hear(*this);
  serve({reader.route()});
}

SampleHandle Writer::make(std::size_t data_bytes, std::size_t bytes_behind) {
  return make_of(make_image(data_bytes, static_cast<std::uint32_t>(sequence_ + 1)), bytes_behind);
}

SampleHandle Writer::memory_for(std::size_t bytes) {
  return port_.memory() == nullptr ? pool_->take(bytes) : port_.memory()->loan(bytes);
}

SendStatus Writer::publish(std::size_t data_bytes) {
  const SampleHandle sample = make(data_bytes);
  return sample ? port_->send(sample) : SendStatus::dropped;
}

void Writer::publish_to(Reader& reader, std::size_t data_bytes) {
  const std::uint64_t before = reader.port().arrivals(id_);
  ASSERT_EQ(publish(data_bytes), SendStatus::sent);
  ASSERT_TRUE(eventually([&] { return reader.port().arrivals(id_) != before; }, hang_timeout)) << sequence_;
}

Flood::Flood(Stage& stage, std::vector<core::Route> routes, std::size_t data_bytes, core::EndpointId id)
    : writer_(stage, id) {
  writer_.serve(std::move(routes));
  thread_ = std::jthread([this, data_bytes](const std::stop_token& stop) {
    while (!stop.stop_requested()) writer_.publish(data_bytes);
  });
}

std::vector<std::uint64_t> numbers(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> all(last + 1 - first);
  std::iota(all.begin(), all.end(), first);
  return all;
}

Selection selection(const std::string& text, const TypeSupport& type) {
  return type.closed(type.parse_selection(text).value());
}

testing::AssertionResult is_image(const SampleHandle& sample, std::size_t data_bytes) {
  if (!sample) return testing::AssertionFailure() << "there is no sample";
  const Image image = make_image(data_bytes, static_cast<std::uint32_t>(sample->sequence));
  const SampleHeader& header = sample->header();
  const std::span<const std::byte> body(sample->data + header.body_offset, header.body_bytes);
  if (udp::test::same_bytes(body, encoded_body(image, sample->mask))) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "sample " << sample->sequence << " has other bytes";
}

testing::AssertionResult is_part(const SampleHandle& sample, std::size_t data_bytes,
                                 const Selection& wanted) {
  if (!sample) return testing::AssertionFailure() << "there is no sample";
  const Image image = make_image(data_bytes, static_cast<std::uint32_t>(sample->sequence));
  const SampleHeader& header = sample->header();
  const std::span<const std::byte> body(sample->data + header.body_offset, header.body_bytes);
  if (sample->mask != wanted.mask() || sample->parts != wanted.parts_hash())
    return testing::AssertionFailure() << "sample " << sample->sequence << " is of another selection";
  if (udp::test::same_bytes(body, encoded_body(part_of(image, wanted), wanted.mask())))
    return testing::AssertionSuccess();
  return testing::AssertionFailure() << "sample " << sample->sequence << " has other bytes";
}

void Conformance::SetUp() {
  if (const std::string refusal = stage.medium->refusal(); !refusal.empty()) GTEST_SKIP() << refusal;
  stage.there = stage.medium->open();
  stage.here = stage.medium->open();
}

}  // namespace sft::conformance
