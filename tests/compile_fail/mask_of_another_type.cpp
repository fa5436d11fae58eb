// expect: no matching (member )?function for call to .*subscriber
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Node& node) { return node.subscriber<PointCloud2, Image::Field::height>("points"); }
