#include "core/vanilla/vanilla_writer.h"

#include <algorithm>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "core/discovery/dds_domain.h"
#include "core/platform/quotes.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/dds_qos.h"
#include "core/vanilla/type_hash.h"
#include "core/vanilla/vanilla_matching.h"

namespace sft::core {

namespace {

/// The limits of the samples that the writer keeps, by size and number. A reader whose process was stopped
/// keeps these samples, and two more, in use. So the writer keeps fewer samples if they are large.
constexpr std::size_t kept_bytes = 16 << 20;
constexpr std::size_t kept_samples = 10;
constexpr std::size_t readers_counted = 1024;
// The maximum number for one topic, so that the costs of forged readers are limited
constexpr std::size_t complaints_max = 16;

/// Returns the QoS of the writer. A writer with DDS_HISTORY_KEEP_LAST never waits for its readers.
DdsQos qos_of(const VanillaWriter::Spec& spec, const std::string& user_data) {
  const Qos offered = offered_to_vanilla(spec.qos);
  const bool retains = offered.durability == Durability::transient_local;
  const std::size_t resent =
      std::clamp<std::size_t>(kept_bytes / std::max<std::size_t>(spec.max_sample_bytes, 1), 1, kept_samples);
  const auto depth = static_cast<std::int32_t>(retains ? offered.history_depth : resent);
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  if (retains) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  if (offered.deadline.count() > 0) dds_qset_deadline(qos.get(), offered.deadline.count());
  if (offered.lifespan.count() > 0) dds_qset_lifespan(qos.get(), offered.lifespan.count());
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  return qos;
}

}  // namespace

VanillaWriter::VanillaWriter(std::shared_ptr<VanillaDomain> domain, Spec spec)
    : domain_(std::move(domain)),
      spec_(std::move(spec)),
      type_name_(dds_type(spec_.type->name(), spec_.names)),
      type_hash_(ros_type_hash(spec_.type->type()).value_or("")) {}

Result<std::shared_ptr<VanillaWriter>> VanillaWriter::open(std::shared_ptr<VanillaDomain> domain, Spec spec) {
  std::shared_ptr<VanillaWriter> writer(new VanillaWriter(std::move(domain), std::move(spec)));
  if (Result<void> opened = writer->open(); !opened) return tl::unexpected(opened.error());
  return writer;
}

Result<void> VanillaWriter::open() {
  const CycloneMessages messages;
  const std::string name = dds_topic(spec_.topic, spec_.names);
  const auto refused = [&](dds_return_t status) {
    return fail(Errc::system, "DDS topic " + in_quotes(name) + " of type " + in_quotes(type_name_) + ": " +
                                  dds_strretcode(status) + " (" + messages.text() + ")");
  };
  topic_ = raw_topic(domain_->participant(), name, type_name_);
  if (topic_.entity < 0) return refused(topic_.entity);
  dds_listener_t* const listener = dds_create_listener(this);
  dds_lset_publication_matched(listener, [](dds_entity_t, dds_publication_matched_status_t, void* self) {
    static_cast<VanillaWriter*>(self)->spec_.readers_changed();
  });
  const DdsQos qos = qos_of(spec_, endpoint_user_data(type_hash_, spec_.id));
  writer_ = dds_create_writer(domain_->participant(), topic_.entity, qos.get(), listener);
  dds_delete_listener(listener);
  return writer_ < 0 ? refused(writer_) : Result<void>();
}

VanillaWriter::~VanillaWriter() {
  if (writer_ > 0) dds_delete(writer_);  // waits until no listener runs any more
  if (topic_.entity > 0) dds_delete(topic_.entity);
}

std::size_t VanillaWriter::readers() const {
  std::vector<dds_instance_handle_t> handles(readers_counted);
  const dds_return_t matched = dds_get_matched_subscriptions(writer_, handles.data(), handles.size());
  handles.resize(std::clamp<std::size_t>(static_cast<std::size_t>(std::max(matched, 0)), 0, handles.size()));
  const auto is_vanilla = [this](dds_instance_handle_t handle) {
    dds_builtintopic_endpoint_t* const reader = dds_get_matched_subscription_data(writer_, handle);
    if (reader == nullptr) return false;
    const bool is_ours = is_endpoint_of_sft(reader->qos);
    dds_builtintopic_free_endpoint(reader);
    return !is_ours;
  };
  return static_cast<std::size_t>(std::ranges::count_if(handles, is_vanilla));
}

std::set<std::string> VanillaWriter::complaints() const {
  const Qos offered = offered_to_vanilla(spec_.qos);
  std::set<std::string> complaints;
  for (const VanillaEndpoint& reader : domain_->readers().of(dds_topic(spec_.topic, spec_.names))) {
    if (complaints.size() == complaints_max) break;
    const std::string why_not = why_not_served(type_name_, offered, reader);
    const std::string other = difference_of_hashes(type_hash_, "publisher", reader);
    if (!why_not.empty()) {
      complaints.insert("a reader of DDS is not served: " + why_not);
    } else if (!other.empty()) {
      complaints.insert("a reader of DDS misreads what it gets: " + other);
    }
  }
  return complaints;
}

bool VanillaWriter::is_acknowledged(std::chrono::nanoseconds within) const {
  return dds_wait_for_acks(writer_, within.count()) == DDS_RETCODE_OK;
}

void VanillaWriter::announce_answers(bool is_answered) const {
  const std::string user_data = endpoint_user_data(type_hash_, spec_.id, is_answered);
  const DdsQos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  dds_set_qos(writer_, qos.get());
}

bool VanillaWriter::write(const SampleHandle& sample) noexcept try {
  ddsi_serdata* const data = raw_sample(topic_.type, sample, spec_.type->index_slots());
  return dds_forwardcdr(writer_, data) == DDS_RETCODE_OK;
} catch (const std::bad_alloc&) {
  return false;
}

}  // namespace sft::core
