// What a run of many droplets tells: its events, of all kinds in one form, and its balance, each as
// one flat row of doubles.
#pragma once

#include <limits>

namespace pinchoff {

#define PINCHOFF_EVENT_KINDS(KIND) \
    KIND(contact)                  \
    KIND(breakup)                  \
    KIND(entered)                  \
    KIND(left)                     \
    KIND(touched)                  \
    KIND(parted)                   \
    KIND(merge)                    \
    KIND(unmerged)                 \
    KIND(respaced)                 \
    KIND(retired)
#define PINCHOFF_ENTRY(name) name,
enum class EventKind { PINCHOFF_EVENT_KINDS(PINCHOFF_ENTRY) };
#undef PINCHOFF_ENTRY

/// One event of any kind; not a number where a field has no meaning.
#define PINCHOFF_EVENT_FIELDS(FIELD) \
    FIELD(kind)                      \
    FIELD(time)                      \
    FIELD(droplet_id)                \
    FIELD(x)                         \
    FIELD(y)                         \
    FIELD(area)                      \
    FIELD(obstacle)                  \
    FIELD(symmetry)                  \
    FIELD(impact_parameter)          \
    FIELD(speed)                     \
    FIELD(shape_parameter)           \
    FIELD(daughter_1)                \
    FIELD(daughter_2)                \
    FIELD(area_1)                    \
    FIELD(area_2)                    \
    FIELD(neck_thickness)            \
    FIELD(partner)                   \
    FIELD(into)                      \
    FIELD(facing_length)             \
    FIELD(clock)                     \
    FIELD(since)                     \
    FIELD(waited)                    \
    FIELD(guard)                     \
    FIELD(guard_value)
#define PINCHOFF_DECLARE(name) double name = std::numeric_limits<double>::quiet_NaN();
struct EmulsionEvent {
    PINCHOFF_EVENT_FIELDS(PINCHOFF_DECLARE)
};
#undef PINCHOFF_DECLARE
inline constexpr int kEventFields = sizeof(EmulsionEvent) / sizeof(double);

/// What has happened so far, in numbers: start + entered + breakups - merges - left - retired are
/// present.
#define PINCHOFF_BALANCE_FIELDS(FIELD) \
    FIELD(start)                       \
    FIELD(entered)                     \
    FIELD(breakups)                    \
    FIELD(merges)                      \
    FIELD(unmerged)                    \
    FIELD(touches)                     \
    FIELD(left)                        \
    FIELD(retired)                     \
    FIELD(respaced)                    \
    FIELD(contacts)                    \
    FIELD(waits)                       \
    FIELD(area_in)                     \
    FIELD(area_left)                   \
    FIELD(area_retired)                \
    FIELD(steps)                       \
    FIELD(vertex_updates)              \
    FIELD(windows)                     \
    FIELD(islands)                     \
    FIELD(undone)
#define PINCHOFF_DECLARE(name) double name = 0;
struct Balance {
    PINCHOFF_BALANCE_FIELDS(PINCHOFF_DECLARE)
};
#undef PINCHOFF_DECLARE
inline constexpr int kBalanceFields = sizeof(Balance) / sizeof(double);

}  // namespace pinchoff
