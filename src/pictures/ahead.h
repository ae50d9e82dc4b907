#pragma once

namespace fumarole::pictures {

/// Says that a picture will be read or written: where OpenImageIO is opened at run time that begins
/// now, beside what else there is to do. Reading and writing open it themselves; an error is
/// theirs.
void open_ahead();

/// Its destructor waits for what was begun: a process must not end while libraries are being opened
/// in it.
class AtEnd {
public:
    AtEnd() = default;
    AtEnd(const AtEnd&) = delete;
    AtEnd& operator=(const AtEnd&) = delete;
    ~AtEnd();  // NOLINT(performance-trivially-destructible): its body is one of two, by the build
};

}  // namespace fumarole::pictures
