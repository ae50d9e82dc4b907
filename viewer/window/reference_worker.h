#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "window/background.h"
#include <fumarole/scene.h>

namespace fumarole::window {

/// The reference of what is on the screen, in the background, tile by tile.
class ReferenceWorker {
public:
    /// What there is of it. RGB, linear, rows from the top; `done` is 1 where a pixel is there.
    struct Picture {
        int width = 0, height = 0;
        std::vector<float> composite;
        std::vector<std::uint8_t> done;
        double share = 0;  ///< share of the pixels, 0..1
        bool whole = false;
        std::string error;
        std::uint64_t version = 0;  ///< another whenever something came
    };

    /// Starts over. @param scene its resolution is the picture's
    void start(const Scene& scene, double tolerance, int bounces);
    void stop();
    [[nodiscard]] bool busy() const { return task_.busy(); }

    /// Copies what is there, if it is not what `picture` has already.
    void update(Picture& picture) const;

private:
    struct Mail {
        std::mutex lock;
        Picture picture;
    };
    std::shared_ptr<Mail> mail_ = std::make_shared<Mail>();
    std::uint64_t versions_ = 0;
    Background task_;
};

}  // namespace fumarole::window
