#include "core/node/vanilla_serving.h"

#include <utility>

#include "core/node/vanilla_access.h"

namespace sft::core {

namespace {
/// The time for which the agent waits for acknowledgements of the samples that were sent last.
constexpr std::chrono::milliseconds answered_within{100};
constexpr std::chrono::seconds waits_again_after{60};
}  // namespace

VanillaServing::~VanillaServing() {
  if (outlet_ != nullptr) outlet_->close();
}

/// A publisher that retains samples has the outlet even without readers, because its retained samples must
/// be in the DDS writer before a reader joins.
bool VanillaServing::reconcile(Time now) {
  if (node_.vanilla == nullptr) return false;
  const std::shared_ptr<VanillaDomain>& domain = node_.vanilla->domain();
  if (writer_ != nullptr && writer_->domain() != domain) {
    retired_ = std::exchange(outlet_, nullptr);
    writer_.reset();
  }
  if (writer_ == nullptr && domain != nullptr) open_writer(now);
  if (domain == nullptr) opening_ = {};
  name_complaints();
  if (writer_ != nullptr) node_.vanilla->add_writer(writer_->guid());
  const std::size_t readers = writer_ == nullptr ? 0 : writer_->readers();
  const bool wanted = writer_ != nullptr && (readers > 0 || core_.retains());
  if (wanted && outlet_ == nullptr) {
    const auto write = [writer = writer_](const SampleHandle& sample) { return writer->write(sample); };
    outlet_ = std::make_shared<VanillaOutlet>(write, core_.retains() ? core_.spec().qos.history_depth : 0);
    outlet_->show_readers(readers);
    return true;
  }
  if (writer_ != nullptr && !wanted) opening_ = {};
  if (!wanted && outlet_ != nullptr) retired_ = std::exchange(outlet_, nullptr);
  if (outlet_ != nullptr && outlet_->readers() != readers) {
    outlet_->show_readers(readers);
    core_.vanilla_readers_changed();
  }
  if (retired_ == nullptr) start_outlet(now);  // if an earlier attempt has failed, this is the next one
  return retired_ != nullptr;
}

void VanillaServing::in_force() {
  if (const auto retired = std::exchange(retired_, nullptr)) retired->close();
  start_outlet(std::chrono::steady_clock::now());
}

void VanillaServing::start_outlet(Time now) {
  if (outlet_ == nullptr || outlet_->is_started() || !opening_.due(now)) return;
  const ThreadSpec thread("dds-send", node_.vanilla->setup().sender);
  const Result<void> started = outlet_->start(thread);
  started ? opening_.succeeded() : failed(started.error(), now);
}

void VanillaServing::open_writer(Time now) {
  if (!opening_.due(now)) return;
  Result<std::shared_ptr<VanillaWriter>> writer = VanillaWriter::open(
      node_.vanilla->domain(), {.id = core_.spec().id,
                                .topic = core_.spec().topic,
                                .names = node_.vanilla->names(),
                                .type = &core_.type(),
                                .qos = core_.spec().qos,
                                .max_sample_bytes = core_.spec().max_sample_bytes,
                                .readers_changed = node_.vanilla->setup().endpoints_changed});
  if (!writer) return failed(writer.error(), now);
  opening_.succeeded();
  writer_ = std::move(*writer);
}

bool VanillaServing::look(Time now) {
  look_at_answers(now);
  return opening_.due_again(now);
}

/// DDS reports only whether all samples were acknowledged. If samples follow each other closely, some are
/// always under way. So the agent waits for a moment before it concludes that a reader does not acknowledge
/// samples.
void VanillaServing::look_at_answers(Time now) {
  const bool has_readers = outlet_ != nullptr && outlet_->readers() > 0;
  bool is_answered = !has_readers || writer_->is_acknowledged({});
  if (is_answered) {
    waits_at_ = now + unanswered_max;
  } else {
    if (now < waits_at_ || !node_.vanilla->may_wait(now)) return;
    is_answered = writer_->is_acknowledged(answered_within);
    waits_at_ = now + waits_again_after;
  }
  if (std::exchange(is_answered_, is_answered) == is_answered || writer_ == nullptr) return;
  writer_->announce_answers(is_answered);
  if (is_answered) return;
  node_.log.write(LogLevel::warning,
                  core_.spec().topic +
                      ": a reader of DDS does not acknowledge what it is sent: its program is stopped or too "
                      "slow, or a firewall drops its answers; other readers lose nothing by that");
}

void VanillaServing::name_complaints() {
  const std::uint64_t changes = writer_ == nullptr ? 0 : writer_->domain()->readers().changes();
  if (std::exchange(readers_changes_, changes) == changes) return;
  std::set<std::string> complaints = writer_ == nullptr ? std::set<std::string>() : writer_->complaints();
  for (const std::string& complaint : complaints) {
    if (complaints_.contains(complaint)) continue;
    node_.log.write(LogLevel::warning, core_.spec().topic + ": " + complaint);
  }
  complaints_ = std::move(complaints);
}

void VanillaServing::failed(const Error& error, Time now) {
  if (!opening_.failed(error.message, now)) return;
  node_.log.write(LogLevel::warning, core_.spec().topic + ": DDS readers are not served: " + error.message);
}

}  // namespace sft::core
