// expect: (use of deleted function .*operator->|selected deleted operator .->)
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Subscriber<PointCloud2, F::height>& subscriber) { return subscriber.take()->height(); }
