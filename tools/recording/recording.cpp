#include "tools/recording/recording.h"

#include <algorithm>
#include <utility>

namespace sft::recording {

namespace {

constexpr std::size_t faults_most = 1000;

}  // namespace

void Recording::add_fault(std::string fault) {
  if (std::ranges::find(faults_, fault) != faults_.end()) return;
  if (faults_.size() == faults_most) fault = "there are more faults";
  if (faults_.size() <= faults_most) faults_.push_back(std::move(fault));
}

bool Recording::is_stopped() {
  const bool is_it = is_stopped_ && is_stopped_();
  if (is_it) add_fault("reading was interrupted");
  return is_it;
}

void Recording::add(Schema schema, const std::string& where) {
  if (schema.id == 0) return;  // the specification of MCAP requires readers to ignore this schema
  const auto [known, is_new] = schemas_.try_emplace(schema.id, schema);
  if (!is_new && known->second != schema)
    add_fault(where + ": schema " + std::to_string(schema.id) + " is there twice, with two definitions");
}

void Recording::add(Channel channel, const std::string& where) {
  const auto [known, is_new] = channels_.try_emplace(channel.id, channel);
  if (!is_new && known->second != channel)
    add_fault(where + ": channel " + std::to_string(channel.id) + " is there twice, with two meanings");
}

}  // namespace sft::recording
