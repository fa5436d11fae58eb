#include "core/node/vanilla_hearing.h"

#include <algorithm>
#include <utility>

#include "core/names/names.h"
#include "core/node/vanilla_access.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/type_hash.h"

namespace sft::core {

namespace {

// The maximum number for one topic, so that the costs of forged writers are limited
constexpr std::size_t reasons_max = 16;

const char* text_of(RawFault fault) {
  switch (fault) {
    case RawFault::none:
      break;
    case RawFault::malformed:
      return "the message does not fit the type";
    case RawFault::other_encoding:
      return "it is not encoded as XCDR1";
    case RawFault::no_memory:
      return "no memory is free for it: take samples sooner, or raise UdpSettings::memory_limit_bytes";
  }
  return "";
}

}  // namespace

VanillaHearing::VanillaHearing(NodeContext& node, SubscriberCore& core, Feed& feed)
    : node_(node), core_(core), feed_(feed) {}

void VanillaHearing::reconcile(Time now) {
  if (node_.vanilla == nullptr) return;
  const std::shared_ptr<VanillaDomain>& domain = node_.vanilla->domain();
  if (reader_ != nullptr && reader_->domain() != domain) reader_.reset();
  look_at_writers();
  if (inlet_ != nullptr) inlet_->ask(feed_.ports().requested(), feed_.ports().min_period_us());
  if (is_wanted()) wanted_at_ = now;
  const bool hears = is_wanted() || (reader_ != nullptr && reader_->hears() && !is_heard_no_more(now));
  if (domain == nullptr || (reader_ != nullptr && reader_->hears() == hears)) {
    opening_ = {};
  } else {
    open_reader(hears, now);
  }
  if (reader_ == nullptr) return;
  name_faults();
  node_.vanilla->add_reader(reader_->guid());
}

bool VanillaHearing::is_wanted() const {
  return std::ranges::any_of(writers_, [](const Writer& writer) { return writer.why_not.empty(); });
}

bool VanillaHearing::is_heard_no_more(Time now) const { return !is_wanted() && now - wanted_at_ >= kept; }

bool VanillaHearing::is_due(Time now) const {
  return opening_.due_again(now) || (reader_ != nullptr && reader_->hears() && is_heard_no_more(now));
}

void VanillaHearing::look_at_writers() {
  const VanillaEndpoints* const known = node_.vanilla->writers();
  if (known == nullptr) {
    writers_.clear();
    changes_ = 0;
    return;
  }
  if (const std::uint64_t now = known->changes(); std::exchange(changes_, now) == now) return;
  const SubscriberCore::Spec& spec = core_.spec();
  const DdsNames names = node_.vanilla->names();
  const std::string type_name = dds_type(spec.type->name(), names);
  const std::string type_hash = ros_type_hash(spec.type->type()).value_or("");
  const Qos requested = requested_from_vanilla(feed_.spec().qos);
  writers_.clear();
  std::vector<EndpointId> present;
  std::set<std::string> unheard;
  for (VanillaEndpoint& writer : known->of(dds_topic(spec.topic, names))) {
    if (writers_.size() == writers_per_reader_max) break;
    std::string why_not = why_not_heard(type_name, type_hash, requested, writer);
    if (!why_not.empty() && unheard.size() < reasons_max && unheard.insert(why_not).second &&
        !unheard_.contains(why_not))
      warn("a writer of DDS is not heard: " + why_not);
    present.push_back(writer.id);
    writers_.push_back({std::move(writer), std::move(why_not)});
  }
  unheard_ = std::move(unheard);
  if (inlet_ != nullptr) inlet_->forget_others_than(present);
}

/// Opens the DDS reader. The thread that receives samples wakes the subscriber by its doorbell, as
/// publishers in shared memory do. So callbacks of the program never run on a thread of Cyclone.
void VanillaHearing::open_reader(bool hears, Time now) {
  if (!opening_.due(now)) return;
  const SubscriberCore::Spec& spec = core_.spec();
  if (hears && inlet_ == nullptr) {
    inlet_ = std::make_shared<VanillaInlet>(*spec.type, spec.options.depth, spec.options.depth_bytes);
    inlet_->ask(feed_.ports().requested(), feed_.ports().min_period_us());
    feed_.ports().set_vanilla(inlet_);
  }
  Result<std::unique_ptr<VanillaReader>> reader = VanillaReader::open(
      node_.vanilla->domain(),
      {.id = feed_.spec().id,
       .topic = spec.topic,
       .names = node_.vanilla->names(),
       .reading = {.type = spec.type, .type_owner = spec.type_owner, .memory = spec.copies},
       .qos = feed_.spec().qos,
       .hears = hears,
       .arrived = [inlet = inlet_](const VanillaArrival& arrival) { return inlet->put(arrival); },
       .wake = [&core = core_] { core.wake(); },
       .changed = node_.vanilla->setup().endpoints_changed});
  if (!reader) {
    if (opening_.failed(reader.error().message, now))
      warn((hears ? "writers of DDS are not heard: " : "nodes of ROS 2 do not see the subscriber: ") +
           reader.error().message);
    return;
  }
  opening_.succeeded();
  reader_ = std::move(*reader);
}

void VanillaHearing::name_faults() {
  const std::set<RawFault> faults = reader_->faults();
  for (const RawFault fault : faults) {
    if (faults_.insert(fault).second)
      warn(std::string("a sample of a writer of DDS cannot be read, and is discarded: ") + text_of(fault));
  }
}

void VanillaHearing::warn(const std::string& text) const {
  node_.log.write(LogLevel::warning, core_.spec().topic + ": " + text);
}

std::string VanillaHearing::node_of(const VanillaEndpoint& writer) const {
  const std::shared_ptr<VanillaDomain>& domain = node_.vanilla->domain();
  std::string name = domain == nullptr ? "" : domain->graph().node_of(writer.key);
  return name.empty() ? writer.participant : name;
}

/// Returns the state of each unmodified writer. Leases are checked by DDS: a writer whose lease has expired
/// is not listed any more.
std::vector<Hearing> VanillaHearing::hearing() const {
  std::vector<Hearing> hearing;
  for (const Writer& writer : writers_) {
    const VanillaEndpoint& endpoint = writer.endpoint;
    const bool is_heard = writer.why_not.empty() && reader_ != nullptr && reader_->hears();
    Hearing& added = hearing.emplace_back();
    added.source.writer = endpoint.id;
    added.offered = endpoint.qos;
    added.offered.liveliness_lease = {};
    added.status = {.id = endpoint.id,
                    .node = node_of(endpoint),
                    .matched = is_heard,
                    .connected = is_heard && reader_->is_matched(endpoint.id),
                    .transport = TransportKind::dds,
                    .reason = is_heard ? "it knows nothing of SFT" : writer.why_not};
  }
  return hearing;
}

}  // namespace sft::core
