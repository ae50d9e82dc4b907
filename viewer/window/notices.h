#pragma once

#include "study/flag_names.h"
#include <string>
#include <utility>

namespace fumarole::window {

/// What the window tells a person: an error message, until it is closed, and a note, for a while.
class Notices {
public:
    void show_message(std::string_view message) { message_ = study::with_flags(message); }
    void close_message() { message_.clear(); }
    /// The error message that is shown, or "".
    [[nodiscard]] const std::string& message() const { return message_; }

    void show_note(std::string note)
    {
        constexpr double kSeconds = 4;
        note_ = std::move(note);
        seconds_left_ = kSeconds;
    }
    /// Takes the time that went by from the note's.
    void pass(double seconds) { seconds_left_ -= seconds; }
    /// The note, or "" once its time is over.
    [[nodiscard]] std::string note() const { return seconds_left_ > 0 ? note_ : ""; }

private:
    std::string message_, note_;
    double seconds_left_ = 0;
};

}  // namespace fumarole::window
