#pragma once

#include <optional>
#include <utility>

namespace fumarole::light {

/// An answer that is dear, which stays as long as all that its key names does. What the key leaves
/// out may change: the answer is then that of when it was asked.
template <typename Key, typename Answer> class LastAnswer {
public:
    /// @param ask gives the answer where the key is another
    template <typename Ask> const Answer& of(Key key, const Ask& ask)
    {
        if (key_ != key) {
            last_ = ask();
            key_ = std::move(key);
        }
        return last_;
    }
    [[nodiscard]] const Answer& last() const { return last_; }

private:
    std::optional<Key> key_;
    Answer last_{};
};

}  // namespace fumarole::light
