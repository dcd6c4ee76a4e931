# Our keepers and takers.
#   docker build -f docker/players.Dockerfile -t rcss-hat .
#   docker run --rm --network host rcss-hat play --on localhost:6000 --keepers hand --episodes 100
FROM python:3.11-slim

RUN useradd --create-home --uid 1000 rcss
WORKDIR /home/rcss/rcss-hat
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY rcss_hat rcss_hat
COPY fake_server fake_server
RUN pip install --no-cache-dir --constraint constraints.txt .

USER 1000
WORKDIR /home/rcss
# Compile the kernels once, so that players answer from their first cycle on.
RUN rcss-hat play --on fake --keepers hand --episodes 1 --seed 1

ENTRYPOINT ["rcss-hat"]
CMD ["--help"]
