// The attributes by which Clang checks two rules at compile time: a lock is held where it has to be
// (-Wthread-safety), and objects that can be used only once are not used twice (-Wconsumed). With other
// compilers these macros are empty.
//
// They are the only macros of the project. They are needed because Clang knows most of these attributes only
// in the GNU spelling, which other compilers refuse. They do not configure anything.
#pragma once

#if defined(__clang__)
#define SFT_THREAD_ATTRIBUTE(attribute) __attribute__((attribute))
#else
#define SFT_THREAD_ATTRIBUTE(attribute)
#endif

/// The member is read and written only while this mutex is held.
#define SFT_GUARDED_BY(mutex) SFT_THREAD_ATTRIBUTE(guarded_by(mutex))
/// The object to which the pointer points is read and written only while this mutex is held.
#define SFT_PT_GUARDED_BY(mutex) SFT_THREAD_ATTRIBUTE(pt_guarded_by(mutex))

/// A thread that takes several of these mutexes takes this mutex after (or before) the given ones
/// (lock_order.h).
#define SFT_ACQUIRED_AFTER(...) SFT_THREAD_ATTRIBUTE(acquired_after(__VA_ARGS__))
#define SFT_ACQUIRED_BEFORE(...) SFT_THREAD_ATTRIBUTE(acquired_before(__VA_ARGS__))

/// The caller of the function must hold these mutexes.
#define SFT_REQUIRES(...) SFT_THREAD_ATTRIBUTE(requires_capability(__VA_ARGS__))
/// The caller of the function must not hold these mutexes.
#define SFT_EXCLUDES(...) SFT_THREAD_ATTRIBUTE(locks_excluded(__VA_ARGS__))

/// The function locks these mutexes. Without an argument it locks the object itself.
#define SFT_ACQUIRE(...) SFT_THREAD_ATTRIBUTE(acquire_capability(__VA_ARGS__))
/// The function unlocks these mutexes. Without an argument it unlocks the object itself.
#define SFT_RELEASE(...) SFT_THREAD_ATTRIBUTE(release_capability(__VA_ARGS__))
/// The function has locked the mutex if it returns the value of the first argument.
#define SFT_TRY_ACQUIRE(...) SFT_THREAD_ATTRIBUTE(try_acquire_capability(__VA_ARGS__))

/// The class is a mutex. `kind` is the name for it in Clang's messages.
#define SFT_CAPABILITY(kind) SFT_THREAD_ATTRIBUTE(capability(kind))
/// An object of the class locks a mutex in its constructor, and unlocks it in its destructor.
#define SFT_SCOPED_CAPABILITY SFT_THREAD_ATTRIBUTE(scoped_lockable)

/// An object of the class is used once, by a function that is marked SFT_USES (-Wconsumed).
#define SFT_USED_ONCE SFT_THREAD_ATTRIBUTE(consumable(unconsumed))
#define SFT_USES SFT_THREAD_ATTRIBUTE(callable_when("unconsumed", "unknown"))

/// Clang does not check the body of the function. A comment at the function says why.
#define SFT_NO_THREAD_SAFETY_ANALYSIS SFT_THREAD_ATTRIBUTE(no_thread_safety_analysis)
