#include "core/dds_domain.h"

#include <dds/ddsrt/log.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>

#include <map>
#include <memory>
#include <mutex>

namespace sft::core {

namespace {
thread_local CycloneMessages* listening = nullptr;

/// Cyclone tells that a domain exists, but not how it is configured. So this has to be remembered where
/// Cyclone keeps the domain itself, which is the process.
struct OpenDomains {
  std::mutex mutex;
  std::map<std::uint32_t, std::string> configurations;  ///< empty: not opened by SFT
};
OpenDomains open_domains;

struct IfaddrsDeleter {
  void operator()(ifaddrs* list) const { ::freeifaddrs(list); }
};

/// Cyclone uses one family for all, IPv4 unless it is told otherwise.
bool host_has_only_ipv6() {
  ifaddrs* first = nullptr;
  ::getifaddrs(&first);
  const std::unique_ptr<ifaddrs, IfaddrsDeleter> list(first);
  bool has_ipv6 = false;
  for (const ifaddrs* i = list.get(); i != nullptr; i = i->ifa_next) {
    const bool usable =
        i->ifa_addr != nullptr && (i->ifa_flags & IFF_UP) != 0 && (i->ifa_flags & IFF_LOOPBACK) == 0;
    if (usable && i->ifa_addr->sa_family == AF_INET) return false;
    has_ipv6 |= usable && i->ifa_addr->sa_family == AF_INET6;
  }
  return has_ipv6;
}

/// Not part of what is compared: that the host's addresses change is nobody's mistake.
std::string for_this_host(const std::string& config) {
  constexpr const char* ipv6 =
      "<CycloneDDS><Domain id=\"any\"><General><Transport>udp6</Transport></General></Domain></CycloneDDS>,";
  return (host_has_only_ipv6() ? ipv6 : "") + config;
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

Result<void> open_dds_domain(std::uint32_t domain, DdsConfig& config) {
  const std::scoped_lock lock(open_domains.mutex);
  const CycloneMessages messages;
  if (const auto known = open_domains.configurations.find(domain);
      known != open_domains.configurations.end()) {
    if (known->second == config.text) return {};
    if (!known->second.empty()) {
      return fail(Errc::invalid_argument,
                  "DDS domain " + std::to_string(domain) +
                      " has been opened in this process with other discovery settings or another "
                      "cyclonedds_config; a "
                      "process can configure it only once: give all its nodes the same");
    }
  } else {
    const dds_entity_t created = dds_create_domain(domain, for_this_host(config.text).c_str());
    if (created < 0 && created != DDS_RETCODE_PRECONDITION_NOT_MET) {
      return fail(Errc::invalid_argument, "Cyclone DDS refuses its configuration (" + messages.text() +
                                              "); check CYCLONEDDS_URI or NodeOptions::cyclonedds_config");
    }
    open_domains.configurations[domain] = created < 0 ? "" : config.text;
    if (created >= 0) {
      config.warnings.insert(config.warnings.end(), messages.errors().begin(), messages.errors().end());
      return {};
    }
  }
  config.summary = "as the program itself configured DDS domain " + std::to_string(domain);
  config.warnings = {
      "the program opened DDS domain " + std::to_string(domain) +
      " before its first node: neither discovery settings nor CYCLONEDDS_URI are applied by SFT"};
  return {};
}

}  // namespace sft::core
