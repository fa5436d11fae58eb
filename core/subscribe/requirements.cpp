#include "core/subscribe/requirements.h"

namespace sft::core {

Requirements declared_requirements(const TypeSupport& type, const Selection& requested) {
  Requirements all;
  all.mask = requested.mask();
  all.text = type.format_selection(requested);
  for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf)
    all.fields.push_back({.path = type.path(leaf), .requested = all.mask.contains(leaf)});
  return all;
}

Requirements recorded_requirements(const TypeSupport& type, const Selection& requested,
                                   const Recorder& recorder) {
  Requirements all = declared_requirements(type, requested);
  const Recorder::Use use = recorder.use();
  all.recorded = true;
  all.samples = use.samples;
  all.text = type.format_selection(use.read);
  all.mask = type.none();
  for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf) {
    all.fields[leaf].samples = use.leaves[leaf].samples;
    all.fields[leaf].last_sample = use.leaves[leaf].last_sample;
    if (use.leaves[leaf].samples != 0) all.mask.insert(leaf);
  }
  return all;
}

}  // namespace sft::core
