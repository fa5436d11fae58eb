#include "core/subscribe/requirements.h"

namespace sft::core {

Requirements declared_requirements(const TypeSupport& type, const FieldMask& requested) {
  Requirements all;
  all.mask = requested;
  all.text = type.format_mask(all.mask);
  for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf)
    all.fields.push_back({.path = type.path(leaf), .requested = requested.contains(leaf)});
  return all;
}

Requirements recorded_requirements(const TypeSupport& type, const FieldMask& requested,
                                   const Recorder& recorder) {
  Requirements all = declared_requirements(type, requested);
  const Recorder::Use use = recorder.use();
  all.recorded = true;
  all.samples = use.samples;
  all.mask = type.none();
  for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf) {
    all.fields[leaf].samples = use.leaves[leaf].samples;
    all.fields[leaf].last_sample = use.leaves[leaf].last_sample;
    if (use.leaves[leaf].samples != 0) all.mask.insert(leaf);
  }
  all.text = type.format_mask(all.mask);
  return all;
}

}  // namespace sft::core
