// expect: (use of deleted function .*operator->|selected deleted operator .->)
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Publisher<PointCloud2>& publisher) { return publisher.loan(PointCloud2{}).value()->data(); }
