//! What robots and mediator say to each other: messages, key expressions, versions
