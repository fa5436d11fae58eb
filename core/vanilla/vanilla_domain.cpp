#include "core/vanilla/vanilla_domain.h"

#include <link.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/discovery/dds_domain.h"
#include "core/discovery/participant_data.h"
#include "core/sync/mutex.h"
#include "core/vanilla/dds_qos.h"
#include "core/vanilla/vanilla_config.h"

namespace sft::core {

namespace {

/// The domains of this process that some node uses.
struct OpenVanillaDomains {
  Mutex mutex;
  std::map<std::pair<std::string, ThreadSettings>, std::weak_ptr<VanillaDomain>> by_config
      SFT_GUARDED_BY(mutex);
};
OpenVanillaDomains open_vanilla_domains;

/// Makes the participant. rmw_cyclonedds recognises participants of ROS 2 by the key "enclave".
dds_entity_t create_participant(std::uint32_t domain) {
  const std::string user_data = "enclave=/;" + std::string(vanilla_mark);
  const DdsQos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  return dds_create_participant(domain, qos.get(), nullptr);
}

constexpr std::uint32_t participants_asked = 1024;

/// Returns the value of a property that Cyclone's participants announce.
std::string property_of(const dds_qos_t* qos, const char* name) {
  char* value = nullptr;
  if (!dds_qget_prop(qos, name, &value) || value == nullptr) return {};
  std::string text(value);
  dds_free(value);
  return text;
}

/// The client library of ROS 2, which is the same for every middleware, and the two names that the library
/// of Fast DDS has had.
constexpr std::array<std::string_view, 3> dds_libraries{"/librcl.so", "/libfastrtps.so", "/libfastdds.so"};

int note_dds_library(dl_phdr_info* library, std::size_t, void* found) {
  const std::string_view name = library->dlpi_name == nullptr ? "" : library->dlpi_name;
  const auto is_it = [&](std::string_view one) { return name.find(one) != std::string_view::npos; };
  *static_cast<bool*>(found) |= std::ranges::any_of(dds_libraries, is_it);
  return 0;
}

}  // namespace

Result<std::shared_ptr<VanillaDomain>> VanillaDomain::of(const VanillaPlan& plan) {
  const Result<VanillaConfig> config = vanilla_config(plan.domain, plan.user_config, plan.ros);
  if (!config) return tl::unexpected(config.error());
  if (config->is_secured) {
    return fail(Errc::unavailable,
                "CYCLONEDDS_URI asks for DDS Security, which is not supported for samples to DDS nodes");
  }
  const Lock lock(open_vanilla_domains.mutex);
  std::erase_if(open_vanilla_domains.by_config, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<VanillaDomain>& known = open_vanilla_domains.by_config[{config->text, plan.threads}];
  if (auto open = known.lock()) return open;
  std::vector<std::string> complaints;
  auto domain = cyclone_domain({.config = config->text, .threads = plan.threads}, complaints);
  if (!domain) return tl::unexpected(domain.error());
  const CycloneMessages messages;
  const dds_entity_t participant = create_participant((*domain)->id());
  if (participant < 0) {
    return fail(Errc::unavailable, "the DDS domain cannot be joined: " + messages.text() +
                                       "; check the network interfaces and CYCLONEDDS_URI");
  }
  auto made = std::make_shared<VanillaDomain>(std::move(*domain), participant, plan.guid_bytes);
  known = made;
  return made;
}

VanillaDomain::VanillaDomain(std::shared_ptr<const CycloneDomain> domain, dds_entity_t participant,
                             std::optional<GuidBytes> guid_bytes)
    : domain_(std::move(domain)),
      participant_(participant),
      announced_(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr)) {
  readers_.emplace(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION);
  graph_.emplace(participant, guid_bytes);
}

VanillaDomain::~VanillaDomain() {
  graph_.reset();
  readers_.reset();
  dds_delete(participant_);
}

std::vector<VanillaParticipant> VanillaDomain::participants() const {
  std::vector<void*> samples(participants_asked);
  std::vector<dds_sample_info_t> infos(participants_asked);
  const dds_return_t read =
      dds_read_mask(announced_, samples.data(), infos.data(), participants_asked, participants_asked,
                    DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  std::vector<VanillaParticipant> others;
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(read, 0)); ++i) {
    const auto& one = *static_cast<const dds_builtintopic_participant_t*>(samples[i]);
    if (!infos[i].valid_data || is_endpoint_of_sft(one.qos)) continue;
    const std::string pid = property_of(one.qos, "__Pid");
    others.push_back(
        {.name = name_of_participant(one.key),
         .host = property_of(one.qos, "__Hostname"),
         .process = property_of(one.qos, "__ProcessName") + (pid.empty() ? "" : " (" + pid + ")")});
  }
  if (read > 0) dds_return_loan(announced_, samples.data(), read);
  return others;
}

bool program_speaks_dds(std::uint32_t domain) {
  bool found = program_has_opened(domain);
  dl_iterate_phdr(&note_dds_library, &found);
  return found;
}

}  // namespace sft::core
