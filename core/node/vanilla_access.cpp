#include "core/node/vanilla_access.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/names/names.h"
#include "core/vanilla/dds_names.h"

namespace sft::core {

VanillaAccess::VanillaAccess(Setup setup, NodeLog& log) : setup_(std::move(setup)), log_(log) {
  const std::string name = "/" + setup_.node;
  const std::size_t slash = name.rfind('/');
  shown_.name_space = name.substr(0, std::max<std::size_t>(slash, 1));
  shown_.name = name.substr(slash + 1);
}

bool VanillaAccess::look(const Discovery::Vanilla& heard, bool is_needed, Time now) {
  next_look_ = Time::max();
  const bool wanted = is_wanted(heard, now) && is_needed;
  if (!wanted) {
    opening_ = {};
    in_graph_.reset();
    writers_.reset();
    return std::exchange(domain_, nullptr) != nullptr;
  }
  if (domain_ != nullptr) {
    domain_->readers().look_again(now);
    writers_->look_again(now);
    const std::uint64_t changes = domain_->readers().changes() + writers_->changes();
    const bool has_news = in_graph_->take_news();
    return std::exchange(changes_, changes) != changes || has_news;
  }
  if (opening_.due(now) && open(now)) return true;
  next_look_ = std::min(next_look_, opening_.next());
  return false;
}

bool VanillaAccess::knows_writer(EndpointId id, const std::string& topic) const {
  return writers_ != nullptr && std::ranges::any_of(writers_->of(dds_topic(topic, names())),
                                                    [id](const auto& writer) { return writer.id == id; });
}

std::vector<Discovery::KnownPublisher> VanillaAccess::publishers_of(std::string_view type_name) const {
  std::vector<Discovery::KnownPublisher> publishers;
  if (writers_ == nullptr) return publishers;
  const std::string type = dds_type(type_name, names());
  for (const auto& [dds_name, writer] : writers_->all()) {
    const std::optional<std::string> topic = topic_of_dds(dds_name, names());
    if (writer.type_name == type && topic && fault_of_announced_topic(*topic).empty())
      publishers.push_back({*topic, writer.node.empty() ? writer.participant : writer.node});
  }
  return publishers;
}

VanillaView VanillaAccess::view() const {
  if (domain_ == nullptr) return {};
  VanillaView view{.readers = domain_->readers().all(),
                   .writers = writers_->all(),
                   .participants = domain_->participants(),
                   .of_sft = domain_->readers().of_sft(),
                   .unanswered = writers_->unanswered(),
                   .names = names()};
  view.of_sft.merge(writers_->of_sft());
  for (auto* endpoints : {&view.readers, &view.writers})
    for (VanillaEndpoints::OfTopic& one : *endpoints)
      one.endpoint.node = domain_->graph().node_of(one.endpoint.key);
  return view;
}

bool VanillaAccess::is_wanted(const Discovery::Vanilla& heard, Time now) {
  using enum NodeOptions::VanillaDds;
  if (setup_.choice != automatic) return setup_.choice == always;
  if (heard.is_there) heard_at_ = now;
  if (heard_at_ == Time{} || now - heard_at_ >= kept) return false;
  if (!heard.is_there) next_look_ = heard_at_ + kept;
  return may_serve(heard);
}

/// Returns true unless the program itself uses DDS. The program may begin to use DDS at any time. This is
/// checked whenever a participant appears, because the program's own participant then appears, too.
bool VanillaAccess::may_serve(const Discovery::Vanilla& heard) {
  if (std::exchange(came_, heard.came) == heard.came) return !program_speaks_dds_;
  const bool speaks = setup_.program_speaks(setup_.plan.domain);
  if (speaks && !program_speaks_dds_) {
    log_.write(
        LogLevel::info,
        "DDS nodes are neither served nor heard, because this program speaks DDS itself, and might get "
        "twice what it passes on: choose NodeOptions::VanillaDds::always if it does not pass on "
        "messages");
  }
  program_speaks_dds_ = speaks;
  return !speaks;
}

bool VanillaAccess::open(Time now) {
  Result<std::shared_ptr<VanillaDomain>> opened = setup_.open(setup_.plan);
  if (!opened) {
    if (opening_.failed(opened.error().message, now))
      log_.write(LogLevel::warning, "DDS nodes are neither served nor heard: " + opened.error().message);
    return false;
  }
  opening_.succeeded();
  domain_ = std::move(*opened);
  writers_ = std::make_unique<VanillaEndpoints>(domain_->participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                                setup_.endpoints_changed);
  in_graph_ = std::make_unique<RosGraph::LocalNode>(domain_->graph(), setup_.endpoints_changed);
  log_.write(LogLevel::info,
             "publishers serve nodes of DDS and ROS 2, and subscribers hear them, in DDS domain " +
                 std::to_string(setup_.plan.domain));
  return true;
}

void VanillaAccess::forget_endpoints() {
  shown_.readers.clear();
  shown_.writers.clear();
}

void VanillaAccess::show_endpoints() {
  if (in_graph_ == nullptr) return;
  in_graph_->show(shown_);
  const bool is_divided = domain_->graph().is_divided();
  if (!std::exchange(graph_is_divided_, is_divided) && is_divided) {
    log_.write(LogLevel::warning,
               "nodes of ROS 2 up to Humble and later ones are in DDS domain " +
                   std::to_string(setup_.plan.domain) +
                   ": this node is not in their graph, since what the one kind reads harms the other; "
                   "give the two kinds domains of their own");
  }
}

}  // namespace sft::core
