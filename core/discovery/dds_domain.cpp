#include "core/discovery/dds_domain.h"

#include <dds/ddsrt/log.h>

#include <array>
#include <atomic>
#include <string_view>
#include <thread>
#include <utility>

#include "core/platform/process_limits.h"
#include "core/platform/thread.h"

namespace sft::core {

namespace {
thread_local CycloneMessages* listening = nullptr;

constexpr std::uint32_t first_domain = 1000;  // DDS domains on a network have numbers below 233
/// The greatest domain number that a governance document of DDS Security can name. Cyclone looks up the
/// number that the domain has in this process.
constexpr std::uint32_t last_secured_domain = 230;
constexpr std::size_t descriptors_of_a_domain = 16;
/// The number of threads that must be available: those of Cyclone, those of the node that opens after the
/// domain, and the thread that creates the domain.
constexpr std::size_t threads_of_a_domain = 9;

constexpr const char* name_of_maker = "sft-domain";
/// The beginnings of the names of Cyclone's threads.
constexpr std::array<std::string_view, 10> names_of_cyclone{"gc",  "tev",  "recv",      "dq.",    "lease",
                                                            "fsm", "xmit", "threadmon", "debmon", "ws"};

std::atomic<std::uint32_t> domains_made{0};  // in this process

/// Creates the domain under the greatest free number, because programs use small numbers for their own
/// domains.
std::pair<std::uint32_t, dds_entity_t> make_secured_domain(const std::string& config) {
  for (std::uint32_t id = last_secured_domain; id > 0; --id) {
    const dds_entity_t entity = dds_create_domain(id, config.c_str());
    if (entity != DDS_RETCODE_PRECONDITION_NOT_MET) return {id, entity};
  }
  return {0, DDS_RETCODE_OUT_OF_RESOURCES};
}

std::pair<std::uint32_t, dds_entity_t> make_domain(const DomainPlan& plan) {
  if (plan.is_secured) return make_secured_domain(plan.config);
  const std::uint32_t id = first_domain + domains_made.fetch_add(1);
  return {id, dds_create_domain(id, plan.config.c_str())};
}

struct MadeDomain {
  std::uint32_t id = 0;
  dds_entity_t entity = 0;
  std::string messages{};
  std::vector<std::string> errors{};
};

MadeDomain make(const DomainPlan& plan) {
  const CycloneMessages messages;
  const std::string& prefix = plan.threads.name_prefix;
  const ThreadNames before = prefix.empty() ? ThreadNames() : thread_names();
  const auto [id, entity] = make_domain(plan);
  if (entity >= 0 && !prefix.empty()) prefix_threads_since(before, prefix, names_of_cyclone);
  return {id, entity, messages.text(), messages.errors()};
}

/// Cyclone's threads inherit CPUs and policy from the thread that creates the domain. So a thread with the
/// configured CPUs and policy is started to create it.
Result<MadeDomain> make_in_a_thread_with(const DomainPlan& plan) {
  MadeDomain made;
  ThreadSpec maker(name_of_maker);
  maker.settings = plan.threads;
  Result<std::thread> thread = start_thread(maker, [&] { made = make(plan); });
  if (!thread) return tl::unexpected(thread.error());
  thread->join();
  return made;
}

}  // namespace

CycloneMessages::CycloneMessages() : outer_(listening) {
  listening = this;
  dds_set_log_sink(&on_message, nullptr);
}

CycloneMessages::~CycloneMessages() { listening = outer_; }

void CycloneMessages::on_message(void*, const dds_log_data_t* message) {
  if (listening == nullptr) return;
  std::string text(message->message, message->size);
  while (text.ends_with('\n')) text.pop_back();
  const bool is_error = (message->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0;
  (is_error ? listening->errors_ : listening->warnings_).push_back(std::move(text));
}

std::string CycloneMessages::text() const {
  std::string text;
  for (const auto* messages : {&errors_, &warnings_}) {
    for (const std::string& message : *messages) text += (text.empty() ? "" : "; ") + message;
  }
  return text.empty() ? "it does not say why" : text;
}

Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const DomainPlan& plan,
                                                            std::vector<std::string>& complaints) {
  // Cyclone would crash if descriptors or threads ran out while it creates a domain.
  if (Result<void> enough = check_room_for(descriptors_of_a_domain, threads_of_a_domain); !enough)
    return tl::unexpected(enough.error());
  if (Result<void> enough = check_room_for_select(descriptors_of_a_domain); !enough)
    return tl::unexpected(enough.error());
  Result<MadeDomain> made = make_in_a_thread_with(plan);
  if (!made) return tl::unexpected(made.error());
  if (made->entity < 0)
    return fail(Errc::invalid_argument, "Cyclone DDS refuses its configuration (" + made->messages +
                                            "); check CYCLONEDDS_URI or NodeOptions::cyclonedds_config");
  complaints.insert(complaints.end(), made->errors.begin(), made->errors.end());
  return std::make_shared<const CycloneDomain>(made->id, made->entity);
}

/// Tries to create the domain with an invalid configuration. Cyclone checks whether the domain exists
/// before it reads the configuration. So no domain is created, and the error shows whether the domain
/// exists.
bool program_has_opened(std::uint32_t domain) {
  const CycloneMessages messages;
  return dds_create_domain(domain, "<") == DDS_RETCODE_PRECONDITION_NOT_MET;
}

}  // namespace sft::core
