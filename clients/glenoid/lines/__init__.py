"""Lines that pyserial opens by their URL: it looks for `protocol_NAME` here when asked to (`serial.protocol_handler_packages`)."""
