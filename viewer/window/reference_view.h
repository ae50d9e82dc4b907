#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/metrics.h"
#include "window/reference_worker.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::window {

/// Error of a side against the reference, over the pixels that the reference has.
struct ErrorFigures {
    std::string name;
    study::Metrics metrics;
};

/// The reference of what is on the screen: asked for once that stands still, taken over tile by
/// tile, and what the sides' errors against it are.
class ReferenceView {
public:
    using Picture = ReferenceWorker::Picture;

    /// Asks for the reference of a scene, unless it is the one asked for already, and takes what is
    /// there of it. @param scene its resolution is the picture's
    /// @param moving true while a camera or a light is dragged: nothing is asked for
    /// @param now [s] on any clock
    void follow(const Scene& scene, double tolerance, int bounces, bool moving, double now);
    /// Stops, and drops what was there.
    void drop();

    [[nodiscard]] const Picture& picture() const { return picture_; }
    [[nodiscard]] bool busy() const { return worker_.busy(); }
    /// The composite as far as it is known; RGB, rows from the top.
    [[nodiscard]] Image image() const;

    /// Whether there are pixels that errors() does not know yet.
    [[nodiscard]] bool unmeasured() const
    {
        return picture_.share > 0 && measured_ != picture_.version;
    }
    /// Has the pictures measured again: they are being drawn anew.
    void outdate_errors() { measured_ = 0; }
    /// Measures pictures by name, in the place of those measured before; a picture of another size
    /// is left out.
    void measure(const std::vector<std::pair<std::string, Image>>& pictures);
    [[nodiscard]] const std::vector<ErrorFigures>& errors() const { return errors_; }

private:
    struct Request {
        Scene scene;
        double tolerance = 0;
        int bounces = 0;
    };
    [[nodiscard]] bool asked_for(const Scene& scene, double tolerance, int bounces) const;

    ReferenceWorker worker_;
    std::optional<Request> request_;
    Picture picture_;
    double taken_ = -1;           ///< [s] when the picture was last looked for
    std::uint64_t measured_ = 0;  ///< Picture::version of errors_
    std::vector<ErrorFigures> errors_;
};

}  // namespace fumarole::window
