#pragma once

/// What the shared libraries show; all else in them is hidden.
#define FUMAROLE_API __attribute__((visibility("default")))
