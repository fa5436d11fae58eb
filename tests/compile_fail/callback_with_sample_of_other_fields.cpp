// expect: static assertion failed.*the callback of a subscriber takes a sample and not the message
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Node& node) {
  return node.subscriber<PointCloud2, F::height>("points", [](const sft::Sample<PointCloud2>&) {});
}
