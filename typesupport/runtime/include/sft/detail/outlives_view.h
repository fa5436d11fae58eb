// Precedes a function of a view whose result stays valid after the view is destroyed: a span, a text or
// another view. All of these refer to the sample or to the type. g++ 14 assumes that they refer to the
// view, which is often a temporary, and would warn of `for (double c : sample->pose().covariance())`.
#pragma once

#if __has_cpp_attribute(gnu::no_dangling)
#define SFT_OUTLIVES_VIEW [[gnu::no_dangling]]
#else
#define SFT_OUTLIVES_VIEW
#endif
