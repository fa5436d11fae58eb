#include "core/dds_domain.h"

#include <dds/ddsrt/log.h>
#include <fcntl.h>

#include <atomic>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "core/file_descriptor.h"

namespace sft::core {

namespace {
thread_local CycloneMessages* listening = nullptr;

constexpr std::uint32_t first_domain = 1000;  // DDS domains on a network are below 233
/// A governance document can name no number above this one, and Cyclone looks up the number of this process.
constexpr std::uint32_t last_secured_domain = 230;
constexpr std::size_t descriptors_of_a_domain = 16;
constexpr std::size_t threads_of_a_domain = 8;  // Cyclone's own, and those of the node behind it

/// The domains of this process, kept where Cyclone keeps them.
struct OpenDomains {
  std::mutex mutex;
  std::map<std::string, std::weak_ptr<const CycloneDomain>> by_config;
  std::uint32_t made = 0;
};
OpenDomains open_domains;

/// Cyclone does not survive a lack of descriptors while it makes a domain.
bool has_descriptors_left() {
  std::vector<FileDescriptor> spare;
  for (std::size_t i = 0; i < descriptors_of_a_domain; ++i) {
    spare.emplace_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!spare.back()) return false;
  }
  return true;
}

/// Nor a lack of threads.
bool has_threads_left() {
  std::atomic<bool> all_began{false};
  std::vector<std::jthread> spare;
  bool left = true;
  try {
    for (std::size_t i = 0; i < threads_of_a_domain; ++i)
      spare.emplace_back([&all_began] { all_began.wait(false); });
  } catch (const std::system_error&) {
    left = false;
  }
  all_began = true;
  all_began.notify_all();
  return left;
}

/// Under a number that is free, from the greatest one down: programs use small ones for themselves.
std::pair<std::uint32_t, dds_entity_t> make_secured_domain(const std::string& config) {
  for (std::uint32_t id = last_secured_domain; id > 0; --id) {
    const dds_entity_t entity = dds_create_domain(id, config.c_str());
    if (entity != DDS_RETCODE_PRECONDITION_NOT_MET) return {id, entity};
  }
  return {0, DDS_RETCODE_OUT_OF_RESOURCES};
}

std::pair<std::uint32_t, dds_entity_t> make_domain(const std::string& config, bool is_secured) {
  if (is_secured) return make_secured_domain(config);
  const std::uint32_t id = first_domain + open_domains.made++;
  return {id, dds_create_domain(id, config.c_str())};
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

Result<std::shared_ptr<const CycloneDomain>> cyclone_domain(const std::string& config, bool is_secured,
                                                            const CycloneDomain* instead_of,
                                                            std::vector<std::string>& complaints) {
  const std::scoped_lock lock(open_domains.mutex);  // so that two nodes do not make the same one
  std::erase_if(open_domains.by_config, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<const CycloneDomain>& known = open_domains.by_config[config];
  if (auto domain = known.lock(); domain != nullptr && domain.get() != instead_of) return domain;
  if (!has_descriptors_left())
    return fail(Errc::limit_exceeded,
                "the process has no file descriptors left: raise its limit (ulimit -n)");
  if (!has_threads_left())
    return fail(Errc::limit_exceeded,
                "no more threads can be started: raise the limits of the user (ulimit -u) "
                "or of the service (TasksMax)");
  const CycloneMessages messages;
  const auto [id, entity] = make_domain(config, is_secured);
  if (entity < 0) return fail(Errc::invalid_argument, messages.text());
  complaints.insert(complaints.end(), messages.errors().begin(), messages.errors().end());
  auto domain = std::make_shared<const CycloneDomain>(id, entity);
  known = domain;
  return domain;
}

/// Cyclone looks whether the domain exists before it reads the configuration, and refuses this one.
bool program_has_opened(std::uint32_t domain) {
  const CycloneMessages messages;
  return dds_create_domain(domain, "<") == DDS_RETCODE_PRECONDITION_NOT_MET;
}

}  // namespace sft::core
