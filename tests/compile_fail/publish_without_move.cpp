// expect: (as 'this' argument discards qualifiers|'publish' is an lvalue)
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Loan<PointCloud2>& loan) { return loan.publish(); }
